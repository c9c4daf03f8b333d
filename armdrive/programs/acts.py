"""What a program asks of an arm, act by act: the seam between a program and its performer.

A program's machine gives acts; a performer carries each out and gives the machine its answer.
Acts are whole when given: places are absolute, numbers are computed, so that an act that was
interrupted can be written down, and be done again from wherever it broke off. Units: mm, deg where
a name says so, s; `speed` is a fraction of the limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

from kinematics import Pose


@dataclass(frozen=True, slots=True)
class Mark:
    """Where in a program something stands: line and column count from 1. `file` may be empty."""

    line: int
    column: int = 1
    file: str = ""

    def __str__(self) -> str:
        where = f"line {self.line}, column {self.column}"
        return f"{self.file}: {where}" if self.file else where


@dataclass(frozen=True, slots=True)
class Go:
    """Go to a place: a pose in the base frame, or the joint angles of all joints (deg, by name).

    By a joint motion, or along a straight line. With `opening_mm` the fingers are brought there
    first.
    """

    goal: Pose | Mapping[str, float]
    line: bool = False
    speed: float = 1.0
    opening_mm: float | None = None
    name: str = ""
    """What the program calls the place, for people."""


@dataclass(frozen=True, slots=True)
class Fingers:
    """Bring the fingers to an opening in mm; None opens them all the way. 0 closes them."""

    opening_mm: float | None
    speed: float = 1.0


@dataclass(frozen=True, slots=True)
class Grasp:
    """Close the fingers on what is between them; answered with its width in mm, 0 for nothing."""


@dataclass(frozen=True, slots=True)
class Ready:
    """Go to the park posture of the arm file."""

    speed: float = 1.0


@dataclass(frozen=True, slots=True)
class Home:
    """Reference the arm, where nobody has yet."""


@dataclass(frozen=True, slots=True)
class Delay:
    """Let time pass on the arm's own clock."""

    time_s: float


@dataclass(frozen=True, slots=True)
class Outputs:
    """Switch outputs, counted from 1: on and off; the others stay."""

    on: tuple[int, ...] = ()
    off: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class AwaitInputs:
    """Wait until inputs, counted from 1, are high and low; with a deadline, answered with a bool.

    Answered True when they are; False when `within_s` is over first. Without it, it waits on.
    """

    high: tuple[int, ...] = ()
    low: tuple[int, ...] = ()
    within_s: float | None = None


@dataclass(frozen=True, slots=True)
class ReadInput:
    """Read an input, counted from 1; answered with a bool."""

    number: int


@dataclass(frozen=True, slots=True)
class Look:
    """Look where the arm stands; answered with `Seen`. Sends nothing that moves."""


@dataclass(frozen=True, slots=True)
class Seen:
    """Where the arm stands: the answer to `Look`. `opening_mm` is None where nobody knows it."""

    pose: Pose
    joints_deg: Mapping[str, float]
    opening_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Remember:
    """Write a place down under a name, in the arm's own file of points."""

    name: str
    joints_deg: Mapping[str, float]
    opening_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Say:
    """Tell the person a line of text."""

    text: str


@dataclass(frozen=True, slots=True)
class Hold:
    """Wait until a person lets the program go on."""

    text: str = ""


Act: TypeAlias = (
    Go
    | Fingers
    | Grasp
    | Ready
    | Home
    | Delay
    | Outputs
    | AwaitInputs
    | ReadInput
    | Look
    | Remember
    | Say
    | Hold
)
Answer: TypeAlias = float | bool | Seen | None

MOTIONS = (Go, Fingers, Grasp, Ready, Home)
"""The acts that move the arm."""


@dataclass(frozen=True, slots=True)
class Stage:
    """An act of a program, and where it stands there; `calls` are the calls that led to it."""

    act: Act
    mark: Mark
    calls: tuple[Mark, ...] = field(default=())


class Machine(Protocol):
    """A program under way, pure: it knows no arm and no clock."""

    def next(self) -> Stage | None:
        """Return the act to be carried out now, the same until it is answered; None at the end."""

    def answer(self, answer: Answer) -> None:
        """Say what the act brought, and go on behind it."""

    def snapshot(self) -> dict[str, object]:
        """Return all that the program knows at this point, as plain JSON data."""
