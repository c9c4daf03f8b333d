"""Targets handed to a drive in profile position: both ends, alone and wired back to back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.errors import LocalProtocolError

IDLE, READY, ACK, MOVING = 0x0637, 0x0237, 0x1237, 0x0237


def enabled() -> canopen.DriveDevice:
    drive = canopen.DriveDevice()
    drive.happen(canopen.Happening.INITIALISED)
    for row in canopen.way(drive.state, canopen.DriveState.ENABLED):
        drive.control(canopen.Controlword.of(row.cause))
    return drive


def heard(host, *values) -> list[object]:
    return [event for value in values for event in host.hear(canopen.Statusword(value))]


def test_a_target_is_asked_for_acknowledged_released_and_reached():
    host = canopen.SetPointHost()
    host.begin()
    assert [
        (host.controlword.value, host.phase, heard(host, value))
        for value in (IDLE, ACK, READY, MOVING, IDLE)
    ] == [
        (0x2F, canopen.Phase.WAITING, []),
        (0x3F, canopen.Phase.ASKING, [canopen.Taken()]),
        (0x2F, canopen.Phase.RELEASING, []),
        (0x2F, canopen.Phase.UNDER_WAY, []),
        (0x2F, canopen.Phase.UNDER_WAY, [canopen.Reached()]),
    ]
    assert (host.controlword.value, host.phase) == (0x2F, canopen.Phase.FREE)


def test_what_was_reached_before_is_not_believed():
    host = canopen.SetPointHost()
    host.begin(relative=True, at_once=False)
    assert heard(host, IDLE, IDLE, IDLE | 0x1000, IDLE | 0x1000) == [canopen.Taken()]
    assert host.controlword == canopen.Controlword(0x4F)
    assert heard(host, IDLE) == [canopen.Reached()]


def test_room_is_waited_for_and_nothing_is_asked_twice():
    host = canopen.SetPointHost()
    host.begin(at_once=False)
    assert heard(host, ACK, ACK) == []
    assert not host.controlword.has(canopen.ControlBit.NEW_SET_POINT)
    heard(host, READY)
    assert host.controlword.has(canopen.ControlBit.NEW_SET_POINT)
    with pytest.raises(LocalProtocolError, match="a set-point is asking"):
        host.begin()
    host.forget()
    assert not host.controlword.has(canopen.ControlBit.NEW_SET_POINT)
    host.begin()


def test_a_halt_ends_in_standing_and_the_old_target_is_not_driven_to_any_more():
    host = canopen.SetPointHost()
    host.begin()
    heard(host, IDLE, ACK, READY)
    host.halt()
    assert host.controlword.has(canopen.ControlBit.HALT)
    with pytest.raises(LocalProtocolError, match="a set-point is halting"):
        host.begin()
    assert heard(host, MOVING, IDLE) == [canopen.Stood()]
    with pytest.raises(LocalProtocolError, match="or the old one goes on"):
        host.begin(at_once=False)
    host.begin()
    heard(host, IDLE)
    assert host.controlword == canopen.Controlword(0x13F)  # it stands until the new one is taken
    heard(host, ACK)
    assert host.controlword == canopen.Controlword(0x2F)


def test_standing_is_not_believed_of_a_drive_that_has_not_begun():
    host = canopen.SetPointHost()
    host.begin()
    heard(host, IDLE)
    host.halt()
    assert heard(host, IDLE, IDLE) == []
    assert host.phase is canopen.Phase.HALTING
    assert heard(host, MOVING, IDLE) == [canopen.Stood()]


@pytest.mark.parametrize("word", [0x0218, 0x0217, 0x0233, 0x0001])
def test_a_drive_that_is_not_enabled_has_lost_its_target(word):
    host = canopen.SetPointHost()
    host.begin()
    heard(host, IDLE, ACK)
    assert heard(host, word, word) == [canopen.Disabled(canopen.Statusword(word).state)]
    assert host.phase is canopen.Phase.FREE


def test_a_following_error_is_told_once():
    host = canopen.SetPointHost()
    assert heard(host, 0x2237, 0x2237, 0x0237, 0x2237) == [canopen.FollowingError()] * 2
    assert heard(host, 0x0218, 0x2237) == [canopen.FollowingError()]
    assert canopen.SetPointHost().hear(enabled().statusword(canopen.StatusBit.FOLLOWING_ERROR)) == (
        canopen.FollowingError(),
    )


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


class Wire:
    """A master and a drive that hear of each other's words only now and then."""

    def __init__(self) -> None:
        self.host, self.drive = canopen.SetPointHost(), enabled()
        self.target, self.position, self.events = 0, 0, []

    def exchange(self, down: bool, up: bool, moves: bool) -> None:
        if down:
            self.drive.control(self.host.controlword, self.target)
        points = self.drive.points
        if moves and points.halted:
            points.stood()
        elif moves and points.active is not None:
            self.position = points.active.target
            points.arrived()
        if up:
            self.events += self.host.hear(self.drive.statusword())


STEPS = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=12)


@given(st.lists(st.tuples(st.integers(-9, 9), STEPS, st.booleans()), min_size=1, max_size=5))
def test_reached_is_said_only_where_the_drive_is_and_lost_words_only_delay_it(script):
    wire = Wire()
    for target, steps, halts in script:
        wire.target, wire.events = target, []
        wire.host.begin()
        for number, step in enumerate(steps):
            if halts and number == len(steps) // 2:
                wire.host.halt()
            wire.exchange(*step)
            if canopen.Reached() in wire.events:
                assert wire.position == target
        if wire.host.phase is not canopen.Phase.HALTING and not halts:
            for _ in range(4):
                wire.exchange(True, True, True)
            assert wire.events[-1:] == [canopen.Reached()]
            assert wire.events.count(canopen.Taken()) == 1
        wire.host.forget()


@given(
    st.lists(st.tuples(st.sampled_from(("begin", "halt", "forget", "")), st.integers(0, 0xFFFF)))
)
def test_any_statusword_in_any_phase_is_borne(script):
    host = canopen.SetPointHost()
    for act, value in script:
        if act == "begin" and host.phase in (canopen.Phase.FREE, canopen.Phase.UNDER_WAY):
            host.begin()
        elif act in ("halt", "forget"):
            getattr(host, act)()
        host.hear(canopen.Statusword(value))
        assert (
            canopen.Statusword(value).state is canopen.DriveState.ENABLED
            or host.phase is canopen.Phase.FREE
        )
        assert host.controlword.has(canopen.ControlBit.NEW_SET_POINT) == (
            host.phase is canopen.Phase.ASKING
        )
