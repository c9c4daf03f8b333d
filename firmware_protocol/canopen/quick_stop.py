"""What a drive does upon a quick stop: the option codes of object 605A."""

from __future__ import annotations

from enum import IntEnum


class QuickStopOption(IntEnum):
    """How it stops, and whether it then disables itself or stays in QUICK_STOP, holding."""

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
