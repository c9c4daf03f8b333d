"""What the operator has set: mode, increment and speed, and the jog that a key then means."""

from __future__ import annotations

from dataclasses import dataclass, replace

from armdrive.intents import Jog, Space
from tui.keys import JOG_KEYS

INCREMENTS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Sizes of one increment, in degrees for angles and mm for the rest."""

SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0)
"""Fractions of the joint speed limits."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Mode, increment and speed. Every change gives new settings; the ends of a row hold."""

    space: Space = Space.JOINT
    increment_index: int = INCREMENTS.index(2.0)
    speed_index: int = SPEEDS.index(0.25)

    @property
    def cartesian(self) -> bool:
        """Whether keys move the finger tips rather than joints."""
        return self.space is Space.CARTESIAN

    @property
    def increment(self) -> float:
        """One increment, in degrees or mm."""
        return INCREMENTS[self.increment_index]

    @property
    def speed(self) -> float:
        """The fraction of the speed limits."""
        return SPEEDS[self.speed_index]

    def other_mode(self) -> Settings:
        """Switch between joint and Cartesian mode."""
        return replace(self, space=Space.JOINT if self.cartesian else Space.CARTESIAN)

    def with_increment(self, steps: int) -> Settings:
        """Go along the row of increments."""
        index = min(max(self.increment_index + steps, 0), len(INCREMENTS) - 1)
        return replace(self, increment_index=index)

    def with_speed(self, steps: int) -> Settings:
        """Go along the row of speeds."""
        return replace(self, speed_index=min(max(self.speed_index + steps, 0), len(SPEEDS) - 1))

    def increment_of(self, key: str) -> Jog:
        """Return the jog of one tap on a jog key: a distance."""
        return self._jog(key, self.increment)

    def direction_of(self, key: str) -> Jog:
        """Return the jog of a held jog key: a direction."""
        return self._jog(key, 1.0)

    def _jog(self, key: str, amount: float) -> Jog:
        pair, sign = JOG_KEYS[key]
        return Jog(self.space, ((pair.axis(cartesian=self.cartesian), sign * amount),))
