"""From a motor to its joint: full steps, microsteps and a gear or belt, as a sum for people."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from armdrive.interview.readers import WrongAnswer, plain_number

MOST = 100_000.0
"""No gear of an arm turns its motor as often for one turn of the joint."""


@dataclass(frozen=True, slots=True)
class Ratio:
    """Turns of the motor for one turn of its joint; `written` as somebody typed it."""

    turns: float
    written: str

    def __str__(self) -> str:
        return self.written


def ratio(line: str) -> Ratio:
    """Read "20:1", teeth "60/16" (joint over motor), "60/16 * 3", or a plain number.

    Raises `WrongAnswer`.
    """
    turns = 1.0
    for part in line.replace("x", "*").split("*"):
        turns *= _part(part.strip(), line)
    if not 1.0 / MOST <= turns <= MOST:
        raise WrongAnswer(f"a ratio of {turns:g} is none that an arm has: write it like 20:1")
    return Ratio(turns, " ".join(line.split()))


def _part(part: str, line: str) -> float:
    for sign in (":", "/"):
        over, found, under = part.partition(sign)
        if found:
            top, bottom = plain_number(over), plain_number(under)
            if top <= 0.0 or bottom <= 0.0:
                raise WrongAnswer(f"both numbers of {part!r} must be above 0")
            return float(Fraction(top) / Fraction(bottom))
    if not part:
        raise WrongAnswer(f"write a ratio like 20:1 or 60/16, not {line!r}")
    value = plain_number(part)
    if value <= 0.0:
        raise WrongAnswer(f"a ratio must be above 0, not {value:g}")
    return value


@dataclass(frozen=True, slots=True)
class Gearing:
    """How a motor turns a joint, or (`per` in mm) pulls the fingers."""

    full_steps: int
    microsteps: int
    ratio: Ratio

    @property
    def steps_per_turn(self) -> float:
        """Motor steps as the controller counts them, for one turn of the joint."""
        return self.full_steps * self.microsteps * self.ratio.turns

    def __str__(self) -> str:
        if self.microsteps == 1:
            return f"{self.full_steps} counts a turn x {self.ratio} = {self.steps_per_turn:.6g}"
        return (
            f"{self.full_steps} full steps x {self.microsteps} microsteps x {self.ratio} "
            f"= {self.steps_per_turn:.6g}"
        )


def steps_per_mm(full_steps: int, microsteps: int, mm_per_turn: float) -> float:
    """Return the steps of a gripper's motor for each mm that the fingers open."""
    return full_steps * microsteps / mm_per_turn
