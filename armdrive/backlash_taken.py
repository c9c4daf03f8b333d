"""Where every motor is within its backlash, and what that is at least and at most, in steps.

Between what a motor turns and what it drives is the arithmetic of hysteresis: when it turns by n
steps, its taken becomes min(max(taken + n, 0), B), and what is left of n is what has been driven.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from kinematics.spaces import Motors


def turned(taken: int, width: int, steps: int) -> tuple[int, int]:
    """Return taken after a motor has turned by some steps, and the steps that were driven."""
    after = min(max(taken + steps, 0), width)
    return after, steps - (after - taken)


def to_turn(taken: int, width: int, steps: int) -> int:
    """Return how far a motor has to turn so that so many steps are driven."""
    if not steps:
        return 0
    return steps + (width - taken if steps > 0 else -taken)


@dataclass(frozen=True, slots=True)
class Taken:
    """Where motors are within their backlash: the assumption, and what it is at least and most."""

    at: Motors
    least: Motors
    most: Motors

    @classmethod
    def unknown(cls, widths: Motors) -> Taken:
        """Return the middle of each, as nobody knows better."""
        return cls(Motors(width // 2 for width in widths), Motors([0] * len(widths)), widths)

    @classmethod
    def known(cls, at: Motors, widths: Motors, unsure: Iterable[int] = ()) -> Taken:
        """Return what was remembered, of which some motors' was not certain."""
        doubted = set(unsure)
        least = Motors(0 if n in doubted else each for n, each in enumerate(at))
        most = Motors(widths[n] if n in doubted else each for n, each in enumerate(at))
        return cls(at, least, most)

    def doubted(self, widths: Motors) -> Taken:
        """Return the same as an assumption."""
        return Taken(self.at, Motors([0] * len(widths)), widths)

    def centred(self) -> Taken:
        """Return the assumption that is wrong by least."""
        middles = ((low + high) // 2 for low, high in zip(self.least, self.most, strict=True))
        return Taken(Motors(middles), self.least, self.most)

    def after(self, steps: Motors, widths: Motors) -> tuple[Taken, Motors]:
        """Return this when motors have turned, and what they have driven."""
        moved = [turned(*each) for each in zip(self.at, widths, steps, strict=True)]
        least, most = (
            Motors(turned(*each)[0] for each in zip(bound, widths, steps, strict=True))
            for bound in (self.least, self.most)
        )
        return Taken(Motors(new for new, _ in moved), least, most), Motors(n for _, n in moved)

    @property
    def unsure(self) -> tuple[int, ...]:
        """The motors, counted from 0, of which it is not known."""
        bounds = zip(self.least, self.most, strict=True)
        return tuple(n for n, (least, most) in enumerate(bounds) if least != most)
