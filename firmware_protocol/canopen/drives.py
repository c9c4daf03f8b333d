"""The drive profile CiA 402: controlword (6040), statusword (6041), modes and states of a drive.

Bits 4, 5, 6 and 9 of the one, 12 and 13 of the other mean what the mode says; here they have their
names in profile position, and in homing where those differ.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum, IntEnum, IntFlag
from functools import lru_cache
from typing import TypeAlias

from firmware_protocol.errors import BadField, whole

WORD_MAX = 0xFFFF


class ControlBit(IntFlag):
    """Bits of the controlword."""

    SWITCH_ON = 1 << 0
    ENABLE_VOLTAGE = 1 << 1
    NO_QUICK_STOP = 1 << 2
    """0 is the quick stop."""
    ENABLE_OPERATION = 1 << 3
    NEW_SET_POINT = 1 << 4
    """Rising: take the target. In homing: go home."""
    AT_ONCE = 1 << 5
    """What is under way gives way to it; else it comes behind."""
    RELATIVE = 1 << 6
    FAULT_RESET = 1 << 7
    """Rising: leave the fault."""
    HALT = 1 << 8
    """Stand still, and stay enabled."""
    CHANGE_ON_SET_POINT = 1 << 9
    """Go through the set-point before the next without stopping there."""


class StatusBit(IntFlag):
    """Bits of the statusword."""

    READY = 1 << 0
    SWITCHED_ON = 1 << 1
    ENABLED = 1 << 2
    FAULT = 1 << 3
    VOLTAGE = 1 << 4
    """The power section has its voltage."""
    NO_QUICK_STOP = 1 << 5
    DISABLED = 1 << 6
    WARNING = 1 << 7
    REMOTE = 1 << 9
    """The controlword is obeyed."""
    REACHED = 1 << 10
    """The target is reached; while halted, the drive stands."""
    LIMITED = 1 << 11
    """A limit inside the drive is at work."""
    ACKNOWLEDGED = 1 << 12
    """The set-point was taken, or there is no room for another. In homing: home is found."""
    FOLLOWING_ERROR = 1 << 13
    """In homing: it has failed."""


class Command(Enum):
    """What a controlword tells the state machine: mask, value, and the word that says it."""

    DISABLE_VOLTAGE = (0x82, 0x00, 0x00)
    QUICK_STOP = (0x86, 0x02, 0x02)
    SHUT_DOWN = (0x87, 0x06, 0x06)
    SWITCH_ON = (0x8F, 0x07, 0x07)
    """Also: disable operation."""
    ENABLE_OPERATION = (0x8F, 0x0F, 0x0F)
    FAULT_RESET = (0x80, 0x80, 0x80)
    """Upon the rising edge alone."""

    def __init__(self, mask: int, wanted: int, word: int) -> None:
        self.mask = mask
        self.wanted = wanted
        self.word = word


class DriveState(Enum):
    """A state of the drive: mask and value of the statusword by which it is known."""

    NOT_READY = (0x4F, 0x00)
    DISABLED = (0x4F, 0x40)
    """Switch on disabled."""
    READY = (0x6F, 0x21)
    """Ready to switch on."""
    SWITCHED_ON = (0x6F, 0x23)
    ENABLED = (0x6F, 0x27)
    """Operation enabled."""
    QUICK_STOP = (0x6F, 0x07)
    """Quick stop active."""
    FAULT_REACTION = (0x4F, 0x0F)
    """Fault reaction active."""
    FAULT = (0x4F, 0x08)

    def __init__(self, mask: int, wanted: int) -> None:
        self.mask = mask
        self.wanted = wanted

    @property
    def holds(self) -> bool:
        """Whether the motor has current, so that the arm does not sag."""
        return self in (DriveState.ENABLED, DriveState.QUICK_STOP, DriveState.FAULT_REACTION)


NO_CONTROL, NO_STATUS = ControlBit(0), StatusBit(0)
"""No bit beside those of the command, and of the state."""

_STATE_BITS = 0x6F
_OPERATION_BITS = ControlBit.NEW_SET_POINT | ControlBit.AT_ONCE | ControlBit.RELATIVE
_FREE = _OPERATION_BITS | ControlBit.HALT | ControlBit.CHANGE_ON_SET_POINT


@dataclass(frozen=True, slots=True)
class Controlword:
    """What a drive is told, 16 bits."""

    value: int

    def __post_init__(self) -> None:
        whole("controlword", self.value, 0, WORD_MAX)

    @classmethod
    def of(cls, command: Command, bits: ControlBit = NO_CONTROL) -> Controlword:
        """Make one of a command and of bits that leave it as it is."""
        if bits & ~_FREE:
            raise BadField("bits", bits, "none of those that are the command's")
        return cls(int(command.word | bits))

    @property
    def command(self) -> Command:
        """What it tells the state machine; every controlword tells it something."""
        return _command_of(self.value)

    @property
    def bits(self) -> ControlBit:
        """Its named bits."""
        return ControlBit(self.value & _ALL_CONTROL)

    def has(self, bit: ControlBit) -> bool:
        """Whether a bit is set."""
        return bool(self.value & int(bit))  # flags among themselves are slow, and asked often

    def __str__(self) -> str:
        """Write it as manuals do, with its command."""
        return f"{self.value:04X} ({self.command.name.lower().replace('_', ' ')})"


@dataclass(frozen=True, slots=True)
class Statusword:
    """What a drive says of itself, 16 bits."""

    value: int

    def __post_init__(self) -> None:
        whole("statusword", self.value, 0, WORD_MAX)

    @classmethod
    def of(cls, state: DriveState, bits: StatusBit = NO_STATUS) -> Statusword:
        """Make one of a state and of bits that leave it as it is."""
        if bits & _STATE_BITS:
            raise BadField("bits", bits, "none of those that are the state's")
        return cls(int(state.wanted | bits))

    @property
    def state(self) -> DriveState | None:
        """The drive's state; None for a pattern that CiA 402 does not have."""
        return _state_of(self.value)

    @property
    def bits(self) -> StatusBit:
        """Its named bits."""
        return StatusBit(self.value & _ALL_STATUS)

    def has(self, bit: StatusBit) -> bool:
        """Whether a bit is set."""
        return bool(self.value & int(bit))  # flags among themselves are slow, and asked often

    def __str__(self) -> str:
        """Write it as manuals do, with its state."""
        state = self.state
        words = "no state" if state is None else state.name.lower().replace("_", " ")
        return f"{self.value:04X} ({words})"


# Drives say and hear the same few words again and again.


@lru_cache(maxsize=256)
def _command_of(value: int) -> Command:
    return next(each for each in Command if value & each.mask == each.wanted)


@lru_cache(maxsize=256)
def _state_of(value: int) -> DriveState | None:
    return next((each for each in DriveState if value & each.mask == each.wanted), None)


_ALL_CONTROL = sum(ControlBit)
_ALL_STATUS = sum(StatusBit)


# The choices of CiA 402: modes of operation, and what a drive does upon a quick stop.


class OperationMode(IntEnum):
    """What is written to 6060, and shown in 6061 once it is so."""

    NONE = 0
    PROFILE_POSITION = 1
    VELOCITY = 2
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    INTERPOLATED_POSITION = 7
    CYCLIC_POSITION = 8
    """Cyclic synchronous position: a target with every SYNC."""
    CYCLIC_VELOCITY = 9
    CYCLIC_TORQUE = 10


def mode_of(shown: int) -> OperationMode | None:
    """Return the mode that 6061 shows; None for one of the maker's, or reserved."""
    whole("shown", shown, -128, 127)
    return next((mode for mode in OperationMode if mode == shown), None)


def supported_modes(word: int) -> frozenset[OperationMode]:
    """Return the modes that object 6502 says the drive has: bit n is mode n + 1."""
    whole("word", word, 0, 0xFFFF_FFFF)
    return frozenset(mode for mode in OperationMode if mode and word >> mode - 1 & 1)


def supported_word(modes: frozenset[OperationMode]) -> int:
    """Return what object 6502 says of these modes."""
    return sum(1 << mode - 1 for mode in modes if mode)


class QuickStopOption(IntEnum):
    """What is written to 605A: how the drive stops, and whether it then disables itself.

    Otherwise it stays in QUICK_STOP and holds.
    """

    DISABLE = 0
    """No ramp: the motor loses its current at once."""
    RAMP = 1
    QUICK_RAMP = 2
    """Most drives' default."""
    CURRENT_LIMIT = 3
    VOLTAGE_LIMIT = 4
    RAMP_AND_STAY = 5
    QUICK_RAMP_AND_STAY = 6
    """What an arm without brakes wants."""
    CURRENT_LIMIT_AND_STAY = 7
    VOLTAGE_LIMIT_AND_STAY = 8

    @property
    def stays(self) -> bool:
        """Whether the drive stays in QUICK_STOP when it has stopped."""
        return self >= QuickStopOption.RAMP_AND_STAY


# The state machine of a CiA 402 drive: one table, which the drive obeys and the master plans by.
#
#     0, 1  NOT_READY -> DISABLED -> READY -> SWITCHED_ON -> ENABLED -> QUICK_STOP
#     13    any state -> FAULT_REACTION -> FAULT -> DISABLED
#
# Source: CiA 402-2 (IEC 61800-7-201), the finite state automaton and its transitions 0 to 16.


class Happening(Enum):
    """What changes a drive's state without a command."""

    INITIALISED = "its self-test is done"
    QUICK_STOPPED = "the quick stop has ended, and its option says to disable"
    FAULT = "something is wrong"
    REACTED = "the reaction to a fault has ended"


Cause: TypeAlias = Command | Happening


@dataclass(frozen=True, slots=True)
class Transition:
    """A row of the table. `number` is CiA 402's."""

    number: int
    begin: DriveState
    cause: Cause
    end: DriveState

    @property
    def drops_current(self) -> bool:
        """Whether the motor holds before and not behind it: an arm without brakes sags."""
        return self.begin.holds and not self.end.holds


_NOT_READY, _DISABLED, _READY = DriveState.NOT_READY, DriveState.DISABLED, DriveState.READY
_ON, _ENABLED, _QUICK = DriveState.SWITCHED_ON, DriveState.ENABLED, DriveState.QUICK_STOP
_REACTION, _FAULT = DriveState.FAULT_REACTION, DriveState.FAULT

TRANSITIONS: tuple[Transition, ...] = (
    Transition(1, _NOT_READY, Happening.INITIALISED, _DISABLED),
    Transition(2, _DISABLED, Command.SHUT_DOWN, _READY),
    Transition(3, _READY, Command.SWITCH_ON, _ON),
    Transition(3, _READY, Command.ENABLE_OPERATION, _ON),  # and from there by 4, at once
    Transition(4, _ON, Command.ENABLE_OPERATION, _ENABLED),
    Transition(5, _ENABLED, Command.SWITCH_ON, _ON),
    Transition(6, _ON, Command.SHUT_DOWN, _READY),
    Transition(7, _READY, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(7, _READY, Command.QUICK_STOP, _DISABLED),
    Transition(8, _ENABLED, Command.SHUT_DOWN, _READY),
    Transition(9, _ENABLED, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(10, _ON, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(10, _ON, Command.QUICK_STOP, _DISABLED),
    Transition(11, _ENABLED, Command.QUICK_STOP, _QUICK),
    Transition(12, _QUICK, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(12, _QUICK, Happening.QUICK_STOPPED, _DISABLED),
    *(
        Transition(13, state, Happening.FAULT, _REACTION)
        for state in (_NOT_READY, _DISABLED, _READY, _ON, _ENABLED, _QUICK)
    ),
    Transition(14, _REACTION, Happening.REACTED, _FAULT),
    Transition(15, _FAULT, Command.FAULT_RESET, _DISABLED),
    Transition(16, _QUICK, Command.ENABLE_OPERATION, _ENABLED),  # not every drive has it
)

_BY_CAUSE = {(row.begin, row.cause): row for row in TRANSITIONS}
RESUMES, RESETS = 16, 15
"""Transitions that the master takes only when it is told to."""


def transition(state: DriveState, cause: Cause) -> Transition | None:
    """Return what a cause does in a state; None where it does nothing."""
    return _BY_CAUSE.get((state, cause))


def way(
    state: DriveState, goal: DriveState, *, reset: bool = False, resume: bool = False
) -> tuple[Transition, ...] | None:
    """Return the commands that lead from a state to another, the shortest way; None for no way.

    Out of a fault only with `reset`, and from a quick stop back only with `resume`, which not every
    drive has. No way to a state that holds the arm leads through one that drops it. What a drive
    does by itself is waited for: no way leads out of NOT_READY or FAULT_REACTION.
    """
    refused = {RESETS: not reset, RESUMES: not resume}
    found: dict[DriveState, tuple[Transition, ...]] = {state: ()}
    ahead = deque((state,))
    while ahead:
        here = ahead.popleft()
        if here is goal:
            return found[here]
        for row in TRANSITIONS:
            if row.begin is not here or row.end in found or isinstance(row.cause, Happening):
                continue
            if refused.get(row.number, row.drops_current and goal.holds):
                continue
            found[row.end] = (*found[here], row)
            ahead.append(row.end)
    return None
