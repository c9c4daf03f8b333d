"""The choices of CiA 402: modes of operation, and what a drive does upon a quick stop."""

from __future__ import annotations

from enum import IntEnum

from firmware_protocol.errors import whole


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
