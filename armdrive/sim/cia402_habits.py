"""What CiA 402 leaves to the maker of a simulated drive, and how far it may be on its way home."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from firmware_protocol.canopen import OperationMode


class Homing(Enum):
    """How far a drive has come on its way home."""

    NONE = "not begun, or broken off"
    SEEKING = "on its way to its switch"
    LEAVING = "on its way off its switch"
    DONE = "home"
    FAILED = "failed"

    @property
    def searches(self) -> bool:
        """Whether it is on its way."""
        return self in (Homing.SEEKING, Homing.LEAVING)

    @property
    def given_up(self) -> Homing:
        """What is left of it when it is broken off."""
        return Homing.DONE if self is Homing.DONE else Homing.NONE


@dataclass(frozen=True, slots=True)
class Habits:
    """What CiA 402 leaves to the maker; `cia402_twin.KIND` says what each means."""

    modes: frozenset[OperationMode]
    extrapolates: bool = False
    limits: bool = False
    keeps_position: bool = False
    answer_s: float = 0.0005
    boot_s: float = 0.5
    reset_s: float = 0.02
