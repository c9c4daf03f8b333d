"""What the operator has set: mode, increment and speed, and the jog that a key then means."""

from __future__ import annotations

from dataclasses import dataclass, replace

from armdrive.errors import BadRequest
from armdrive.motion.resolve import BASE
from armdrive.moves import Jog, Space
from tui.keys import JOG_PAIRS, JogPair

INCREMENTS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Sizes of one increment, in degrees for angles and mm for the rest."""

SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0)
"""Fractions of the joint speed limits."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Mode, increment and speed. Every change gives new settings; the ends of a row hold.

    `pairs` are the jog keys of the arm, `frames` the frames it knows.
    """

    space: Space = Space.JOINT
    increment_index: int = INCREMENTS.index(2.0)
    speed_index: int = SPEEDS.index(0.25)
    pairs: tuple[JogPair, ...] = JOG_PAIRS
    frames: tuple[str, ...] = (BASE,)
    frame: str = BASE

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

    def with_next_frame(self) -> Settings:
        """Go on to the next frame, from the last one to the first."""
        place = self.frames.index(self.frame) + 1
        return replace(self, frame=self.frames[place % len(self.frames)])

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

    @property
    def rows(self) -> tuple[JogPair, ...]:
        """The pairs that have a row of the screen: those of letters."""
        return tuple(pair for pair in self.pairs if len(pair.plus) == 1)

    def pair_of(self, key: str) -> JogPair | None:
        """Return the pair that a key belongs to, None where this arm has no such axis."""
        return next((pair for pair in self.pairs if key in (pair.plus, pair.minus)), None)

    def _jog(self, key: str, amount: float) -> Jog:
        pair = self.pair_of(key)
        if pair is None:
            raise BadRequest(f"no axis of this arm is moved by the key {key}")
        sign = 1.0 if key == pair.plus else -1.0
        frame = self.frame if self.cartesian else BASE
        return Jog(self.space, ((pair.axis(cartesian=self.cartesian), sign * amount),), frame)
