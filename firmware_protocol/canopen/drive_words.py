"""The controlword (6040) and the statusword (6041) of CiA 402: checked values with named bits.

Bits 4, 5, 6 and 9 of the one, 12 and 13 of the other mean what the mode says; here they have their
names in profile position, and in homing where those differ.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntFlag

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
        return next(each for each in Command if self.value & each.mask == each.wanted)

    @property
    def bits(self) -> ControlBit:
        """Its named bits."""
        return ControlBit(self.value & _ALL_CONTROL)

    def has(self, bit: ControlBit) -> bool:
        """Whether a bit is set."""
        return bool(self.value & bit)

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
        return next((each for each in DriveState if self.value & each.mask == each.wanted), None)

    @property
    def bits(self) -> StatusBit:
        """Its named bits."""
        return StatusBit(self.value & _ALL_STATUS)

    def has(self, bit: StatusBit) -> bool:
        """Whether a bit is set."""
        return bool(self.value & bit)

    def __str__(self) -> str:
        """Write it as manuals do, with its state."""
        state = self.state
        words = "no state" if state is None else state.name.lower().replace("_", " ")
        return f"{self.value:04X} ({words})"


_ALL_CONTROL = sum(ControlBit)
_ALL_STATUS = sum(StatusBit)
