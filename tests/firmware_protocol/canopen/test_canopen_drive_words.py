"""The words of a CiA 402 drive: controlword, statusword, modes of operation."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    Command,
    ControlBit,
    Controlword,
    DriveDevice,
    DriveState,
    OperationMode,
    StatusBit,
    Statusword,
    mode_of,
    supported_modes,
    supported_word,
)
from firmware_protocol.errors import BadField

WORDS = st.integers(0, 0xFFFF)


@given(WORDS)
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
