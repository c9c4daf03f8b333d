"""PDOs of both sides."""

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.canopen.pdo import DevicePdos
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame

ORDER = canopen.Mapping.of_objects(canopen.STANDARD, canopen.CONTROLWORD, canopen.TARGET_POSITION)
STATE = canopen.Mapping.of_objects(canopen.STANDARD, canopen.STATUSWORD, canopen.POSITION)
FIXED = [kind for kind in canopen.DataType if kind.size]


def written(setup) -> list[str]:
    return [f"{each.place} {each.data[::-1].hex().upper()}" for each in setup]


def test_a_target_and_its_controlword_are_these_bytes():
    assert [entry.word for entry in ORDER.entries] == [0x60400010, 0x607A0020]
    assert ORDER.pack((0x1F, -5000)) == bytes.fromhex("1F 00 78 EC FF FF")
    assert STATE.unpack(bytes.fromhex("37 12 78 EC FF FF")) == (0x1237, -5000)


def test_the_first_received_pdo_is_set_up_in_this_order():
    assert written(canopen.first_pdo(canopen.Direction.RECEIVED, 5, ORDER)) == [
        "1400:01 80000205",
        "1600:00 00",
        "1600:01 60400010",
        "1600:02 607A0020",
        "1600:00 02",
        "1400:02 01",
        "1400:01 00000205",
    ]


@given(st.lists(st.sampled_from(FIXED), min_size=1, max_size=8), st.data())
def test_packed_values_are_unpacked_whatever_follows_them(kinds, data):
    entries = tuple(
        canopen.Mapped(canopen.Place(0x2000, sub), kind) for sub, kind in enumerate(kinds)
    )
    if sum(entry.size for entry in entries) > 8:
        with pytest.raises(BadField, match="objects of 1 to 8 bytes together"):
            canopen.Mapping(entries)
        return
    mapping = canopen.Mapping(entries)
    values = tuple(data.draw(st.integers(*kind.limits)) for kind in kinds)
    packed = mapping.pack(values)
    assert len(packed) == mapping.size
    assert mapping.unpack(packed + data.draw(st.binary(max_size=3))) == values
    with pytest.raises(RemoteProtocolError, match="where the PDO has"):
        mapping.unpack(packed[:-1])


def test_a_devices_mapping_is_read_by_the_dictionary():
    for entry in (*ORDER.entries, *STATE.entries):
        assert canopen.Mapped.of(entry.word, canopen.STANDARD) == entry
    with pytest.raises(RemoteProtocolError, match="2000:00 is mapped, and is no object"):
        canopen.Mapped.of(0x20000008, canopen.STANDARD)
    with pytest.raises(RemoteProtocolError, match="6040:00 is mapped with 8 bits; it is U16"):
        canopen.Mapped.of(0x60400008, canopen.STANDARD)


@every_row(
    "make, field",
    [
        (lambda: canopen.Mapped(canopen.DEVICE_NAME, canopen.DataType.VISIBLE_STRING), "type"),
        (lambda: canopen.Mapping(()), "entries"),
        (lambda: canopen.Mapping.of_objects(canopen.STANDARD, canopen.Place(0x6065)), "places"),
        (lambda: ORDER.pack((0x10000, 0)), "U16"),
        (lambda: ORDER.pack((0, 0.5)), "I32"),
        (lambda: canopen.first_pdo(canopen.Direction.RECEIVED, 0, ORDER), "node"),
    ],
)
def test_nonsense_of_ours_names_its_field(make, field):
    with pytest.raises(BadField) as caught:
        make()
    assert caught.value.field == field


# -- The device ------------------------------------------------------------------------------------

ORDER_PLACE, STATE_PLACE = canopen.Place(0x6040), canopen.Place(0x6041)
OBJECTS = canopen.Dictionary(
    [
        canopen.ObjectEntry(
            ORDER_PLACE, "order", canopen.DataType.U16, canopen.Access.RWW, mappable=True
        ),
        canopen.ObjectEntry(
            STATE_PLACE, "state", canopen.DataType.U16, canopen.Access.RO, mappable=True
        ),
    ]
)
IN, OUT = 0x201, 0x181


class Owner:
    """Objects by their places, and what was said and brought."""

    def __init__(self, transmission):
        self.values = {
            canopen.Place(0x1400, 1): IN, canopen.Place(0x1400, 2): transmission,
            canopen.Place(0x1600, 0): 1, canopen.Place(0x1600, 1): 0x60400010,
            canopen.Place(0x1800, 1): OUT, canopen.Place(0x1800, 2): transmission,
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
    assert owner.brought == [[(ORDER_PLACE, 15)]]
    owner.pdos.sync(0.2)
    assert len(owner.brought) == 1


def test_it_goes_with_every_sync_and_not_by_itself():
    for transmission, sent in ((1, 6), (255, 0)):
        owner = Owner(transmission)
        for beat in range(6):
            owner.pdos.sync(beat / 10)
        assert len(owner.said) == sent


def test_one_that_is_too_short_is_refused_and_one_at_once_acts_at_once():
    owner = Owner(transmission=255)
    assert not owner.pdos.take(Frame(IN, b"\x0f"), 0.0)
    assert owner.pdos.take(Frame(IN, b"\x06\x00\xff"), 0.0)
    assert owner.brought == [[(ORDER_PLACE, 6)]]


def test_one_that_is_switched_off_or_maps_what_is_not_there_does_not_exist():
    owner = Owner(transmission=1)
    owner.values[canopen.Place(0x1400, 1)] |= canopen.NOT_VALID
    owner.values[canopen.Place(0x1A00, 1)] = 0x12340010
    owner.pdos.rebuild()
    assert not owner.pdos.received
    owner.pdos.sync(0.0)
    assert not owner.said


COB, COUNT, ENTRY = canopen.Place(0x1400, 1), canopen.Place(0x1600, 0), canopen.Place(0x1600, 1)
OFF = {COB: canopen.NOT_VALID | IN}
EMPTY = OFF | {COUNT: 0}


@every_row(
    "values, place, value, refused",
    [
        ({}, COUNT, 0, canopen.AbortCode.DEVICE_STATE),
        (OFF, COUNT, 0, None),
        (OFF, COUNT, 9, canopen.AbortCode.PDO_TOO_LONG),
        (OFF, COUNT, 2, canopen.AbortCode.NOT_MAPPABLE),
        (OFF, ENTRY, 0x60400010, canopen.AbortCode.DEVICE_STATE),
        ({}, canopen.Place(0x1400, 2), 250, canopen.AbortCode.VALUE),
        ({}, COB, 0, canopen.AbortCode.VALUE),
        ({}, COB, canopen.NOT_VALID | IN, None),
        # only what can be written is mapped into a received one
        (EMPTY, ENTRY, 0x60400010, None),
        (EMPTY, ENTRY, 0x60410010, canopen.AbortCode.NOT_MAPPABLE),
        (EMPTY, ENTRY, 0x12340010, canopen.AbortCode.NO_OBJECT),
        (EMPTY, ENTRY, 0, None),
    ],
)
def test_pdo_parameters_are_changed_in_the_order_of_the_standard(values, place, value, refused):
    owner = Owner(transmission=1)
    owner.values |= values
    assert owner.pdos.refusal(place, value) is refused
