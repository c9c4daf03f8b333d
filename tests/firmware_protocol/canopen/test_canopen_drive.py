"""A CiA 402 drive: its states, words, units and set-points."""

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.canopen import (
    TRANSITIONS,
    Command,
    ControlBit,
    Controlword,
    DriveDevice,
    DriveState,
    Happening,
    OperationMode,
    QuickStopOption,
    StatusBit,
    Statusword,
    mode_of,
    speed_unit_hz,
    supported_modes,
    supported_word,
    transition,
)
from firmware_protocol.errors import BadField

NEXT = {
    # shut down, switch on, enable, quick stop, disable voltage, fault reset: by CiA 402's figure
    DriveState.NOT_READY: "- - - - - -",
    DriveState.DISABLED: "READY - - - - -",
    DriveState.READY: "- SWITCHED_ON ENABLED DISABLED DISABLED -",
    DriveState.SWITCHED_ON: "READY - ENABLED DISABLED DISABLED -",
    DriveState.ENABLED: "READY SWITCHED_ON - QUICK_STOP DISABLED -",
    DriveState.QUICK_STOP: "- - ENABLED - DISABLED -",
    DriveState.FAULT_REACTION: "- - - - - -",
    DriveState.FAULT: "- - - - - DISABLED",
}
ORDERS = (
    Command.SHUT_DOWN,
    Command.SWITCH_ON,
    Command.ENABLE_OPERATION,
    Command.QUICK_STOP,
    Command.DISABLE_VOLTAGE,
    Command.FAULT_RESET,
)


# How many of the first commands lead from "switch on disabled" to each state.
LAST = {
    DriveState.DISABLED: 0,
    DriveState.READY: 1,
    DriveState.SWITCHED_ON: 2,
    DriveState.ENABLED: 3,
    DriveState.QUICK_STOP: 4,
}


def drive_in(state, quick_stop=QuickStopOption.QUICK_RAMP_AND_STAY) -> DriveDevice:
    """Bring a drive to a state by what a master and a mishap can do."""
    drive = DriveDevice(quick_stop)
    if state is DriveState.NOT_READY:
        return drive
    drive.happen(Happening.INITIALISED)
    if state in (DriveState.FAULT_REACTION, DriveState.FAULT):
        drive.happen(Happening.FAULT)
        if state is DriveState.FAULT:
            drive.happen(Happening.REACTED)
        return drive
    for command in ORDERS[: LAST[state]]:
        drive.control(Controlword.of(command))
    assert drive.state is state
    return drive


@pytest.mark.parametrize("state", DriveState)
def test_every_controlword_does_in_every_state_what_the_figure_says(state):
    expected = dict(zip(ORDERS, NEXT[state].split(), strict=True))
    assert set(expected) == set(Command)
    for value in range(0x400):
        drive = drive_in(state)
        word = Controlword(value)
        drive.control(word)
        ends = expected[word.command]
        assert drive.state is (state if ends == "-" else DriveState[ends]), word


def test_the_table_has_every_number_of_the_standard_and_a_cause_has_one_effect():
    assert {row.number for row in TRANSITIONS} == set(range(1, 17))
    assert len({(row.begin, row.cause) for row in TRANSITIONS}) == len(TRANSITIONS)
    assert all(transition(row.begin, row.cause) is row for row in TRANSITIONS)
    drops = {row.number for row in TRANSITIONS if row.begin.holds and not row.end.holds}
    assert drops == {5, 8, 9, 12, 14}


def test_a_fault_is_reset_by_a_rising_bit_and_not_while_it_lasts():
    drive = drive_in(DriveState.ENABLED)
    assert drive.happen(Happening.FAULT).end is DriveState.FAULT_REACTION
    assert drive.happen(Happening.FAULT) is None
    assert drive.happen(Happening.REACTED).end is DriveState.FAULT
    reset, drive.faulty = Controlword.of(Command.FAULT_RESET), True
    assert drive.control(reset) == ((), False)
    drive.faulty = False
    assert drive.control(reset) == ((), False)  # the bit is still up
    drive.control(Controlword(0))
    ((row,), _) = drive.control(reset)
    assert (row.number, drive.state) == (15, DriveState.DISABLED)


@every_row("option", QuickStopOption)
def test_a_quick_stop_ends_as_its_option_says(option):
    drive = drive_in(DriveState.ENABLED, option)
    rows, _ = drive.control(Controlword.of(Command.QUICK_STOP))
    at_once = option is QuickStopOption.DISABLE
    assert [row.number for row in rows] == ([11, 12] if at_once else [11])
    drive.control(Controlword.of(Command.ENABLE_OPERATION))
    if option.stays:
        assert drive.state is DriveState.ENABLED
    elif not at_once:
        assert drive.state is DriveState.QUICK_STOP
        assert drive.happen(Happening.QUICK_STOPPED).number == 12
    stays = drive_in(DriveState.QUICK_STOP, QuickStopOption.QUICK_RAMP_AND_STAY)
    assert stays.happen(Happening.QUICK_STOPPED) is None


# -- its words ------------------------------------------------------------------------------------

ANY_WORD = st.integers(0, 0xFFFF)


@given(ANY_WORD)
def test_every_controlword_is_one_command_and_every_statusword_at_most_one_state(value):
    assert [each for each in Command if value & each.mask == each.wanted] == [
        Controlword(value).command
    ]
    states = [each for each in DriveState if value & each.mask == each.wanted]
    assert (states or [None]) == [Statusword(value).state]


@every_row(
    "value, state, text",
    [
        (0x0000, DriveState.NOT_READY, "0000 (not ready)"),
        (0x0250, DriveState.DISABLED, "0250 (disabled)"),
        (0x0270, DriveState.DISABLED, "0270 (disabled)"),
        (0x0231, DriveState.READY, "0231 (ready)"),
        (0x0233, DriveState.SWITCHED_ON, "0233 (switched on)"),
        (0x1637, DriveState.ENABLED, "1637 (enabled)"),
        (0x0217, DriveState.QUICK_STOP, "0217 (quick stop)"),
        (0x021F, DriveState.FAULT_REACTION, "021F (fault reaction)"),
        (0x0238, DriveState.FAULT, "0238 (fault)"),
        (0x0001, None, "0001 (no state)"),
    ],
)
def test_a_statusword_tells_its_state(value, state, text):
    assert Statusword(value).state is state
    assert str(Statusword(value)) == text


def test_words_have_named_bits():
    word = Statusword(0x3637)
    assert word.has(StatusBit.FOLLOWING_ERROR)
    assert word.has(StatusBit.REACHED)
    assert word.has(StatusBit.REMOTE)
    assert not word.has(StatusBit.WARNING)
    order = Controlword.of(Command.ENABLE_OPERATION, ControlBit.NEW_SET_POINT | ControlBit.AT_ONCE)
    assert str(order) == "003F (enable operation)"
    assert Controlword.of(Command.ENABLE_OPERATION, ControlBit.HALT) == Controlword(0x10F)
    assert [Controlword.of(each).value for each in Command] == [0, 2, 6, 7, 15, 0x80]
    assert Controlword(0xF80F).command is Command.ENABLE_OPERATION  # the maker's own say nothing
    assert Statusword.of(DriveState.ENABLED, StatusBit.VOLTAGE) == Statusword(0x37)
    assert type(order.value) is type(Statusword.of(DriveState.READY).value) is int


@every_row(
    "make",
    [
        lambda: Controlword(0x10000),
        lambda: Statusword(-1),
        lambda: Controlword.of(Command.SHUT_DOWN, ControlBit.SWITCH_ON),
        lambda: Statusword.of(DriveState.READY, StatusBit.FAULT),
        lambda: DriveDevice().statusword(StatusBit.REACHED),
    ],
)
def test_nonsense_of_ours_is_refused(make):
    with pytest.raises(BadField):
        make()


def test_modes_are_told_as_bits_and_shown_as_numbers():
    modes = frozenset((OperationMode.PROFILE_POSITION, OperationMode.HOMING))
    assert supported_word(modes) == 0x21
    assert supported_modes(0x21) == modes
    assert supported_modes(0x80) == {OperationMode.CYCLIC_POSITION}
    assert supported_modes(supported_word(frozenset(OperationMode))) == set(OperationMode) - {
        OperationMode.NONE
    }
    assert (mode_of(8), mode_of(-1), mode_of(5)) == (OperationMode.CYCLIC_POSITION, None, None)


@every_row(
    "word, unit_hz",
    [
        (0x00B5_0300, 1.0),
        (0x00B4_4700, 4000 / 60),
        (0xFFB4_4700, 400 / 60),
        (0xFDB4_4700, 4 / 60),
        (0x00B4_0300, 4000.0),
        (0x00B5_4700, 1 / 60),
        (0x0041_0300, None),
        (0x0000_0000, None),
    ],
)
def test_a_unit_of_speed_is_told_in_increments_a_second(word, unit_hz):
    found = speed_unit_hz(word, 4000.0)
    assert found is unit_hz is None or found == pytest.approx(unit_hz)


# -- set-points -----------------------------------------------------------------------------------

IDLE, READY, ACK = 0x0637, 0x0237, 0x1237


def test_a_target_is_asked_for_acknowledged_and_released():
    host, phases = canopen.SetPointHost(), canopen.SetPointPhase
    # room is waited for first
    for value, word, phase in (
        (ACK, 0x2F, phases.WAITING),
        (IDLE, 0x3F, phases.ASKING),
        (IDLE, 0x3F, phases.ASKING),
        (ACK, 0x2F, phases.RELEASING),
        (READY, 0x2F, phases.TAKEN),
        (ACK, 0x2F, phases.TAKEN),
    ):
        host.receive(Statusword(value))
        assert (host.controlword.value, host.phase) == (word, phase)
    assert host.taken


def test_a_drive_that_leaves_operation_has_no_target_to_be_handed_over():
    for words in ((), (IDLE,), (IDLE, ACK)):
        host = canopen.SetPointHost()
        for value in (*words, 0x0217):
            host.receive(Statusword(value))
        assert host.taken
        assert host.controlword.value == 0x2F


def test_a_bit_that_was_up_before_enabling_moves_nothing():
    drive = drive_in(DriveState.DISABLED)
    for value in (0x06, 0x07, 0x1F, 0x1F):
        assert not drive.control(Controlword(value))[1]
    assert drive.state is DriveState.ENABLED
    assert not drive.points.active


def test_a_drive_that_loses_its_state_loses_its_target():
    drive = drive_in(DriveState.ENABLED)
    assert drive.control(Controlword(0x3F))[1]
    assert not drive.control(Controlword(0x3F))[1]
    drive.happen(Happening.FAULT)
    assert not drive.points.active
    assert drive.control(Controlword(0x3F)) == ((), False)


STEPS = st.lists(st.tuples(st.booleans(), st.booleans()), max_size=12)


@given(st.lists(st.tuples(st.integers(-9, 9), STEPS), min_size=1, max_size=5))
def test_a_target_is_taken_once_and_lost_words_only_delay_it(script):
    """Master and drive hear each other's words only now and then."""
    drive, goals = drive_in(DriveState.ENABLED), []
    for target, steps in script:
        host = canopen.SetPointHost()
        for down, up in (*steps, *[(True, True)] * 4):
            if down and drive.control(host.controlword)[1]:
                goals.append(target)
            if up:
                host.receive(drive.statusword())
        assert host.taken
    assert goals == [target for target, _ in script]
