"""PDOs of both sides, and the set-points of a drive."""

import math

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
    return [f"{each.place} {each.data[::-1].hex().upper()}" for each in setup.writes]


def test_a_target_and_its_controlword_are_these_bytes():
    assert [entry.word for entry in ORDER.entries] == [0x60400010, 0x607A0020]
    assert ORDER.pack((0x1F, -5000)) == bytes.fromhex("1F 00 78 EC FF FF")
    assert STATE.unpack(bytes.fromhex("37 12 78 EC FF FF")) == (0x1237, -5000)


def test_the_first_received_pdo_is_set_up_in_this_order():
    assert written(canopen.PdoSetup(canopen.Direction.RECEIVED, 1, 5, ORDER)) == [
        "1400:01 80000205",
        "1600:00 00",
        "1600:01 60400010",
        "1600:02 607A0020",
        "1600:00 02",
        "1400:02 01",
        "1400:01 00000205",
    ]


@pytest.mark.parametrize(
    ("direction", "ids"),
    [
        (canopen.Direction.TRANSMITTED, [0x185, 0x285, 0x385, 0x485]),
        (canopen.Direction.RECEIVED, [0x205, 0x305, 0x405, 0x505]),
    ],
)
def test_the_first_four_have_ids(direction, ids):
    assert [canopen.PdoSetup(direction, number, 5, STATE).frame_id for number in range(1, 5)] == ids


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
    values = tuple(
        data.draw(st.integers(*kind.limits) if kind.limits else st.just(-0.5)) for kind in kinds
    )
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
        (lambda: ORDER.pack((1,)), "values"),
        (lambda: ORDER.pack((0x10000, 0)), "U16"),
        (lambda: ORDER.pack((0, 0.5)), "I32"),
        (lambda: canopen.PdoSetup("RPDO", 1, 5, ORDER), "direction"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 0, 5, ORDER), "number"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 5, 5, ORDER), "number"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 1, 0, ORDER), "node"),
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
    assert owner.brought == [[(ORDER_PLACE, 15)]]
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
    owner.values[STATE_PLACE] = 7
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
    assert owner.brought == [[(ORDER_PLACE, 6)]]


def test_one_that_is_switched_off_or_maps_what_is_not_there_does_not_exist():
    owner = Owner(transmission=1)
    owner.values[canopen.Place(0x1400, 1)] |= canopen.NOT_VALID
    owner.values[canopen.Place(0x1A00, 1)] = 0x12340010
    owner.pdos.rebuild()
    assert not owner.pdos.received
    assert owner.pdos.due_s == math.inf


@every_row(
    "off, place, value, refused",
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
def test_pdo_parameters_are_changed_in_the_order_of_the_standard(off, place, value, refused):
    owner = Owner(transmission=1)
    owner.values[canopen.Place(0x1400, 1)] |= canopen.NOT_VALID if off else 0
    assert owner.pdos.refusal(place, value) is refused


@every_row(
    "word, refused",
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


# -- Set-points ------------------------------------------------------------------------------------

IDLE, READY, ACK, MOVING = 0x0637, 0x0237, 0x1237, 0x0237


def enabled() -> canopen.DriveDevice:
    drive = canopen.DriveDevice()
    drive.happen(canopen.Happening.INITIALISED)
    for command in (canopen.Command.SHUT_DOWN, canopen.Command.ENABLE_OPERATION):
        drive.control(canopen.Controlword.of(command))
    return drive


def heard(host, *values) -> list[bool]:
    return [host.receive(canopen.Statusword(value)) for value in values]


def test_a_target_is_asked_for_acknowledged_released_and_reached():
    host = canopen.SetPointHost()
    assert [
        (host.controlword.value, host.phase, *heard(host, value))
        for value in (IDLE, ACK, READY, MOVING, IDLE, IDLE)
    ] == [
        (0x2F, canopen.SetPointPhase.WAITING, False),
        (0x3F, canopen.SetPointPhase.ASKING, False),
        (0x2F, canopen.SetPointPhase.RELEASING, False),
        (0x2F, canopen.SetPointPhase.UNDER_WAY, False),
        (0x2F, canopen.SetPointPhase.UNDER_WAY, True),
        (0x2F, canopen.SetPointPhase.FREE, False),
    ]


def test_what_was_reached_before_is_not_believed():
    host = canopen.SetPointHost()
    assert heard(host, IDLE, IDLE, IDLE | 0x1000, IDLE | 0x1000, IDLE) == [*[False] * 4, True]


def test_room_is_waited_for():
    host = canopen.SetPointHost()
    assert not any(heard(host, ACK, ACK))
    assert not host.controlword.has(canopen.ControlBit.NEW_SET_POINT)
    heard(host, READY)
    assert host.controlword.has(canopen.ControlBit.NEW_SET_POINT)


@every_row("word", [0x0218, 0x0217, 0x0233, 0x0001])
def test_a_drive_that_is_not_enabled_has_lost_its_target(word):
    host = canopen.SetPointHost()
    heard(host, IDLE, ACK)
    assert heard(host, word, word) == [False, False]
    assert host.phase is canopen.SetPointPhase.FREE


def test_a_bit_that_was_up_before_enabling_moves_nothing():
    drive = canopen.DriveDevice()
    drive.happen(canopen.Happening.INITIALISED)
    for value in (0x06, 0x07, 0x1F, 0x1F):
        assert drive.control(canopen.Controlword(value), 100)[1] is None
    assert drive.state is canopen.DriveState.ENABLED
    assert drive.points.active is None


def test_a_drive_that_is_enabled_halted_stays_where_it_is():
    drive = canopen.DriveDevice()
    drive.happen(canopen.Happening.INITIALISED)
    for value in (0x06, 0x07, 0x10F):
        drive.control(canopen.Controlword(value))
    assert drive.points.halted
    assert drive.statusword().has(canopen.StatusBit.REACHED)


def test_a_halted_drive_says_when_it_stands_and_goes_on_when_it_may():
    drive = enabled()
    reached = []
    for value in (0x1F, 0x10F, 0x10F, 0x0F):
        drive.control(canopen.Controlword(value), 100)
        reached.append(drive.statusword().has(canopen.StatusBit.REACHED))
        if len(reached) == 2:
            drive.points.stood()
    assert reached == [False, False, True, False]
    assert drive.points.active == canopen.SetPoint(100, False, False)


def test_a_drive_takes_one_target_and_keeps_one_behind_it():
    drive = enabled()
    first, second, third = (canopen.SetPoint(target, False, False) for target in (10, 20, 30))
    put = dict.fromkeys((first, second, third))
    for point in put:
        put[point] = drive.control(canopen.Controlword(0x1F), point.target)[1]
        drive.control(canopen.Controlword(0x0F), point.target)
    assert list(put.values()) == [first, None, None]
    assert drive.statusword().has(canopen.StatusBit.ACKNOWLEDGED)  # no room
    assert drive.points.arrived() == second
    assert not drive.statusword().has(canopen.StatusBit.ACKNOWLEDGED)
    assert drive.control(canopen.Controlword(0x7F), 5)[1] == canopen.SetPoint(5, True, True)
    assert not drive.statusword().has(canopen.StatusBit.REACHED)
    assert drive.points.arrived() is None
    assert drive.statusword().has(canopen.StatusBit.REACHED)


def test_a_drive_that_loses_its_state_loses_its_targets():
    drive = enabled()
    drive.control(canopen.Controlword(0x1F), 10)
    drive.happen(canopen.Happening.FAULT)
    assert drive.points.active is None
    assert drive.control(canopen.Controlword(0x3F), 10) == ((), None)


STEPS = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=12)


@given(st.lists(st.tuples(st.integers(-9, 9), STEPS), min_size=1, max_size=5))
def test_reached_is_said_only_where_the_drive_is_and_lost_words_only_delay_it(script):
    """Master and drive hear each other's words only now and then."""
    drive, position = enabled(), 0
    for target, steps in script:
        host, reached = canopen.SetPointHost(), False
        for down, up, moves in (*steps, *[(True, True, True)] * 4):
            if down:
                drive.control(host.controlword, target)
            if moves and drive.points.active is not None:
                position = drive.points.active.target
                drive.points.arrived()
            if up and host.receive(drive.statusword()):
                assert not reached
                assert position == target
                reached = True
        assert reached


@given(st.lists(st.integers(0, 0xFFFF)))
def test_any_statusword_in_any_phase_is_borne(values):
    host = canopen.SetPointHost()
    for value in values:
        host.receive(canopen.Statusword(value))
        enabled_still = canopen.Statusword(value).state is canopen.DriveState.ENABLED
        assert enabled_still or host.phase is canopen.SetPointPhase.FREE
        asking = host.controlword.has(canopen.ControlBit.NEW_SET_POINT)
        assert asking == (host.phase is canopen.SetPointPhase.ASKING)
