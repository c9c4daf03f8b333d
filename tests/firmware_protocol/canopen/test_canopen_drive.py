"""CiA 402 drives: their words, the table of states, who obeys it, and the ways through it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

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
    supported_modes,
    supported_word,
    transition,
    way,
)
from firmware_protocol.errors import BadField

WORDS = st.integers(0, 0xFFFF)
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
            drive.mend()
        return drive
    for row in way(drive.state, state):
        drive.control(Controlword.of(row.cause))
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


@pytest.mark.parametrize("state", DriveState)
@pytest.mark.parametrize("happening", Happening)
def test_every_happening_changes_the_state_as_the_figure_says(state, happening):
    ends = {
        (DriveState.NOT_READY, Happening.INITIALISED): DriveState.DISABLED,
        (DriveState.QUICK_STOP, Happening.QUICK_STOPPED): DriveState.DISABLED,
        (DriveState.FAULT_REACTION, Happening.REACTED): DriveState.FAULT,
    }
    in_fault = (DriveState.FAULT_REACTION, DriveState.FAULT)
    if happening is Happening.FAULT and state not in in_fault:
        ends[state, happening] = DriveState.FAULT_REACTION
    drive = drive_in(state)
    drive.quick_stop = QuickStopOption.QUICK_RAMP
    drive.happen(happening)
    assert drive.state is ends.get((state, happening), state)


def test_the_table_has_every_number_of_the_standard_and_a_cause_has_one_effect():
    assert {row.number for row in TRANSITIONS} == set(range(1, 17))
    assert len({(row.begin, row.cause) for row in TRANSITIONS}) == len(TRANSITIONS)
    assert all(transition(row.begin, row.cause) is row for row in TRANSITIONS)
    assert {row.number for row in TRANSITIONS if row.drops_current} == {5, 8, 9, 12, 14}


@pytest.mark.parametrize(
    ("state", "goal", "asked", "numbers"),
    [
        (DriveState.DISABLED, DriveState.ENABLED, {}, [2, 3, 4]),
        (DriveState.ENABLED, DriveState.ENABLED, {}, []),
        (DriveState.ENABLED, DriveState.QUICK_STOP, {}, [11]),
        (DriveState.ENABLED, DriveState.DISABLED, {}, [9]),
        (DriveState.QUICK_STOP, DriveState.DISABLED, {}, [12]),
        (DriveState.QUICK_STOP, DriveState.ENABLED, {}, None),  # the arm would sag
        (DriveState.QUICK_STOP, DriveState.ENABLED, {"resume": True}, [16]),
        (DriveState.FAULT, DriveState.ENABLED, {}, None),
        (DriveState.FAULT, DriveState.ENABLED, {"reset": True}, [15, 2, 3, 4]),
        (DriveState.FAULT_REACTION, DriveState.ENABLED, {"reset": True}, None),
        (DriveState.NOT_READY, DriveState.DISABLED, {"reset": True}, None),
    ],
)
def test_the_way_to_a_state_resets_resumes_and_drops_nothing_unasked(state, goal, asked, numbers):
    found = way(state, goal, **asked)
    assert (None if found is None else [row.number for row in found]) == numbers


@pytest.mark.parametrize("state", DriveState)
@pytest.mark.parametrize("goal", DriveState)
def test_a_drive_goes_every_way_that_is_found(state, goal):
    found = way(state, goal, reset=True, resume=True)
    if found is None:
        assert state in (DriveState.NOT_READY, DriveState.FAULT_REACTION) or goal in (
            DriveState.NOT_READY,
            DriveState.FAULT_REACTION,
            DriveState.FAULT,
        )
        return
    drive = drive_in(state)
    for row in found:
        drive.control(Controlword.of(row.cause))
        assert drive.statusword().state is row.end
    assert drive.state is goal


def test_a_fault_is_reset_by_a_rising_bit_and_not_while_it_lasts():
    drive = drive_in(DriveState.FAULT)
    drive.happen(Happening.FAULT)
    reset = Controlword.of(Command.FAULT_RESET)
    assert drive.control(reset) == ((), None)
    drive.mend()
    assert drive.control(reset) == ((), None)  # the bit is still up
    drive.control(Controlword(0))
    ((row,), _) = drive.control(reset)
    assert (row.number, drive.state) == (15, DriveState.DISABLED)


@pytest.mark.parametrize("option", QuickStopOption)
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


@given(st.lists(WORDS | st.sampled_from(Happening) | st.just("mend"), max_size=30))
def test_no_order_of_words_and_happenings_leaves_the_table(script):
    drive = DriveDevice(QuickStopOption.QUICK_RAMP_AND_STAY)
    for step in script:
        before = drive.state
        if step == "mend":
            drive.mend()
        elif isinstance(step, Happening):
            drive.happen(step)
        else:
            drive.control(Controlword(step), 5)
        assert drive.statusword().state is drive.state
        assert before is drive.state or way_of_one_step(before, drive.state)


def way_of_one_step(before, after):
    direct = any((row.begin, row.end) == (before, after) for row in TRANSITIONS)
    return direct or (before, after) == (DriveState.READY, DriveState.ENABLED)


# -- its words ------------------------------------------------------------------------------------


ANY_WORD = st.integers(0, 0xFFFF)


@given(ANY_WORD)
def test_every_controlword_is_one_command_and_every_statusword_at_most_one_state(value):
    assert [each for each in Command if value & each.mask == each.wanted] == [
        Controlword(value).command
    ]
    states = [each for each in DriveState if value & each.mask == each.wanted]
    assert (states or [None]) == [Statusword(value).state]


@pytest.mark.parametrize(
    ("value", "state", "text"),
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
    assert word.bits & (StatusBit.REACHED | StatusBit.REMOTE | StatusBit.WARNING) == (
        StatusBit.REACHED | StatusBit.REMOTE
    )
    order = Controlword.of(Command.ENABLE_OPERATION, ControlBit.NEW_SET_POINT | ControlBit.AT_ONCE)
    assert str(order) == "003F (enable operation)"
    assert Controlword.of(Command.ENABLE_OPERATION, ControlBit.HALT) == Controlword(0x10F)
    assert [Controlword.of(each).value for each in Command] == [0, 2, 6, 7, 15, 0x80]
    assert Controlword(0xF80F).bits == Controlword(0x000F).bits  # the maker's own are not named
    assert Statusword.of(DriveState.ENABLED, StatusBit.VOLTAGE) == Statusword(0x37)
    assert type(order.value) is type(Statusword.of(DriveState.READY).value) is int


@pytest.mark.parametrize(
    "make",
    [
        lambda: Controlword(0x10000),
        lambda: Statusword(-1),
        lambda: Controlword.of(Command.SHUT_DOWN, ControlBit.SWITCH_ON),
        lambda: Statusword.of(DriveState.READY, StatusBit.FAULT),
        lambda: DriveDevice().statusword(StatusBit.REACHED),
        lambda: mode_of(128),
        lambda: supported_modes(-1),
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
