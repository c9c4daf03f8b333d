"""Targets handed to a drive in profile position: both ends, alone and wired back to back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import canopen

IDLE, READY, ACK, MOVING = 0x0637, 0x0237, 0x1237, 0x0237


def enabled() -> canopen.DriveDevice:
    drive = canopen.DriveDevice()
    drive.happen(canopen.Happening.INITIALISED)
    for row in canopen.way(drive.state, canopen.DriveState.ENABLED):
        drive.control(canopen.Controlword.of(row.cause))
    return drive


def heard(host, *values) -> list[bool]:
    return [host.receive(canopen.Statusword(value)) for value in values]


def test_a_target_is_asked_for_acknowledged_released_and_reached():
    host = canopen.SetPointHost()
    assert [
        (host.controlword.value, host.phase, *heard(host, value))
        for value in (IDLE, ACK, READY, MOVING, IDLE, IDLE)
    ] == [
        (0x2F, canopen.Phase.WAITING, False),
        (0x3F, canopen.Phase.ASKING, False),
        (0x2F, canopen.Phase.RELEASING, False),
        (0x2F, canopen.Phase.UNDER_WAY, False),
        (0x2F, canopen.Phase.UNDER_WAY, True),
        (0x2F, canopen.Phase.FREE, False),
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


@pytest.mark.parametrize("word", [0x0218, 0x0217, 0x0233, 0x0001])
def test_a_drive_that_is_not_enabled_has_lost_its_target(word):
    host = canopen.SetPointHost()
    heard(host, IDLE, ACK)
    assert heard(host, word, word) == [False, False]
    assert host.phase is canopen.Phase.FREE


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
        assert enabled_still or host.phase is canopen.Phase.FREE
        asking = host.controlword.has(canopen.ControlBit.NEW_SET_POINT)
        assert asking == (host.phase is canopen.Phase.ASKING)
