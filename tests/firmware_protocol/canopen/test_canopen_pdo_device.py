"""A device's end of PDOs: when they go, what they bring, and what may be written of them."""

import math

import pytest

from firmware_protocol import canopen
from firmware_protocol.canopen.pdo import DevicePdos
from firmware_protocol.frames import Frame

ORDER, STATE = canopen.Place(0x6040), canopen.Place(0x6041)
OBJECTS = canopen.Dictionary(
    [
        canopen.ObjectEntry(
            ORDER, "order", canopen.DataType.U16, canopen.Access.RWW, mappable=True
        ),
        canopen.ObjectEntry(STATE, "state", canopen.DataType.U16, canopen.Access.RO, mappable=True),
    ]
)
IN, OUT = 0x201, 0x181


class Owner:
    """Objects by their places, and what was said and brought."""

    def __init__(self, transmission, inhibit=0, event_ms=0):
        self.values = {
            canopen.Place(0x1400, 1): IN, canopen.Place(0x1400, 2): transmission,
            canopen.Place(0x1600, 0): 1, canopen.Place(0x1600, 1): 0x60400010,
            canopen.Place(0x1800, 1): OUT, canopen.Place(0x1800, 2): transmission,
            canopen.Place(0x1800, 3): inhibit, canopen.Place(0x1800, 5): event_ms,
            canopen.Place(0x1A00, 0): 1, canopen.Place(0x1A00, 1): 0x60410010,
        }  # fmt: skip
        self.said, self.brought = [], []
        self.pdos = DevicePdos(
            OBJECTS,
            lambda place: self.values.get(place, 0),
            lambda place: lambda _: self.values.get(place, 0),
            lambda values, _: self.brought.append(values),
            lambda frame: self.said.append(frame.data),
        )


def test_by_sync_it_tells_how_it_stood_and_then_acts():
    owner = Owner(transmission=1)
    assert owner.pdos.take(Frame(IN, b"\x0f\x00"), 0.0)
    assert (owner.said, owner.brought) == ([], [])
    owner.pdos.sync(0.1)
    assert owner.said == [b"\x00\x00"]
    assert owner.brought == [[(ORDER, 15)]]
    owner.pdos.sync(0.2)
    assert len(owner.brought) == 1


@pytest.mark.parametrize(("transmission", "sent"), [(1, 6), (3, 2), (0, 1)])
def test_it_goes_with_every_sync_every_so_many_or_after_a_change(transmission, sent):
    owner = Owner(transmission)
    for beat in range(6):
        owner.pdos.sync(beat / 10)
    assert len(owner.said) == sent


def test_on_event_it_goes_at_a_change_no_sooner_than_its_inhibit_time_and_by_its_timer():
    owner = Owner(transmission=255, inhibit=100, event_ms=500)  # 10 ms and 500 ms
    owner.pdos.tell_changes(0.0)
    assert len(owner.said) == 1
    assert owner.pdos.due_s == 0.5
    owner.values[STATE] = 7
    owner.pdos.tell_changes(0.005)
    assert len(owner.said) == 1
    assert owner.pdos.due_s == pytest.approx(0.01)
    owner.pdos.tell_changes(0.01)
    assert owner.said[1:] == [b"\x07\x00"]
    owner.pdos.tell_changes(0.51)
    assert owner.said[2:] == [b"\x07\x00"]


def test_one_that_is_too_short_is_refused_and_one_at_once_acts_at_once():
    owner = Owner(transmission=255)
    assert not owner.pdos.take(Frame(IN, b"\x0f"), 0.0)
    assert owner.pdos.take(Frame(IN, b"\x06\x00\xff"), 0.0)
    assert owner.brought == [[(ORDER, 6)]]


def test_one_that_is_switched_off_or_maps_what_is_not_there_does_not_exist():
    owner = Owner(transmission=1)
    owner.values[canopen.Place(0x1400, 1)] |= canopen.NOT_VALID
    owner.values[canopen.Place(0x1A00, 1)] = 0x12340010
    owner.pdos.rebuild()
    assert not owner.pdos.received
    assert owner.pdos.due_s == math.inf


@pytest.mark.parametrize(
    ("off", "place", "value", "refused"),
    [
        (False, canopen.Place(0x1600, 0), 0, canopen.AbortCode.DEVICE_STATE),
        (True, canopen.Place(0x1600, 0), 0, None),
        (True, canopen.Place(0x1600, 0), 9, canopen.AbortCode.PDO_TOO_LONG),
        (True, canopen.Place(0x1600, 0), 2, canopen.AbortCode.NOT_MAPPABLE),
        (True, canopen.Place(0x1600, 1), 0x60400010, canopen.AbortCode.DEVICE_STATE),
        (False, canopen.Place(0x1400, 2), 250, canopen.AbortCode.VALUE),
        (False, canopen.Place(0x1400, 1), 0, canopen.AbortCode.VALUE),
        (False, canopen.Place(0x1400, 1), canopen.NOT_VALID | IN, None),
    ],
)
def test_what_describes_them_is_changed_in_the_order_of_the_standard(off, place, value, refused):
    owner = Owner(transmission=1)
    owner.values[canopen.Place(0x1400, 1)] |= canopen.NOT_VALID if off else 0
    assert owner.pdos.refusal(place, value) is refused


@pytest.mark.parametrize(
    ("word", "refused"),
    [
        (0x60400010, None),
        (0x60410010, canopen.AbortCode.NOT_MAPPABLE),
        (0x12340010, canopen.AbortCode.NO_OBJECT),
        (0, None),
    ],
)
def test_only_what_can_be_written_is_mapped_into_a_received_one(word, refused):
    owner = Owner(transmission=1)
    owner.values |= {canopen.Place(0x1400, 1): canopen.NOT_VALID | IN, canopen.Place(0x1600, 0): 0}
    assert owner.pdos.refusal(canopen.Place(0x1600, 1), word) is refused
