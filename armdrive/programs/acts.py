"""What a program asks of an arm, act by act: the interface between a program and its performer.

A program's machine gives acts; a performer carries out each and returns its answer to the machine.
An act is complete in itself: its places are absolute and its numbers computed, so an interrupted
act can be written down and repeated from wherever it was interrupted. Units: mm, deg where a name
says so, s; `speed` is a fraction of the limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

from armdrive.arm import Arm
from armdrive.moves import GraspMove, GripperMove, Motion, MoveSequence, ParkMove
from armdrive.programs.language.values import PlaceValue
from armdrive.programs.problems import SourceMark
from armdrive.text.json_forms import move_to_json

# The moves of a program; it has no jogs.
ProgramMove = Motion | GraspMove | MoveSequence


@dataclass(frozen=True, slots=True)
class Go:
    """Carry out a move. The answer to a grasp is the width in mm, 0 if it found nothing."""

    move: ProgramMove
    name: str = ""
    """The program's name of the place, for people."""


@dataclass(frozen=True, slots=True)
class Home:
    """Reference the arm, unless its position is known."""


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
    """Wait until inputs, counted from 1, are high and low.

    The answer is True when they are, and False if `within_s` passes first.
    """

    high: tuple[int, ...] = ()
    low: tuple[int, ...] = ()
    within_s: float | None = None

    def __str__(self) -> str:
        wanted = {**dict.fromkeys(self.high, "on"), **dict.fromkeys(self.low, "off")}
        return " and ".join(f"input {number} is {state}" for number, state in wanted.items())


@dataclass(frozen=True, slots=True)
class ReadInput:
    """Read an input, counted from 1. The answer is a bool."""

    number: int


@dataclass(frozen=True, slots=True)
class Look:
    """Ask where the arm stands; the answer is that place. Moves nothing."""


@dataclass(frozen=True, slots=True)
class Remember:
    """Write a place down under a name, in the arm's own file of points."""

    name: str
    joints_deg: Mapping[str, float]
    opening_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Say:
    """Show the person a line of text."""

    text: str


@dataclass(frozen=True, slots=True)
class Hold:
    """Wait until a person lets the program go on."""

    text: str = ""


Act: TypeAlias = (
    Go | Home | Delay | Outputs | AwaitInputs | ReadInput | Look | Remember | Say | Hold
)
Answer: TypeAlias = float | bool | PlaceValue | None

# The acts that move the arm.
MOTIONS = (Go, Home)


_MOVE_NAMES = MappingProxyType({GripperMove: "Fingers", GraspMove: "Grasp", ParkMove: "Ready"})


def act_name(act: Act) -> str:
    """Return the name of an act, as people read it."""
    if isinstance(act, Go):
        return _MOVE_NAMES.get(type(act.move), "Go")
    return type(act).__name__


def waiting_text(act: Act) -> str:
    """Return what an act waits for, as people read it; "" if it does not wait."""
    match act:
        case Delay(time_s=time_s) if time_s > 0.0:
            return f"waiting {time_s:g} s"
        case AwaitInputs(within_s=limit_s):
            limit = "" if limit_s is None else f", for {limit_s:g} s at most"
            return f"waiting until {act}{limit}"
    return ""


@dataclass(frozen=True, slots=True)
class RunStage:
    """An act of a program, and its place there."""

    act: Act
    mark: SourceMark


@dataclass(frozen=True, slots=True)
class RunStep:
    """One act of a program, or one call of a script.

    `loop` counts the loops of the run from 1. `moves` says whether the arm moves; `waiting` is
    what the step waits for, as people read it. `act` is None for a call. `move` is the act's move,
    resolved from where the arm stands; None if it will be refused.
    """

    arm: Arm
    mark: SourceMark
    name: str
    loop: int = 1
    moves: bool = False
    waiting: str = ""
    act: Act | None = None
    move: ProgramMove | None = None

    def view(self) -> dict[str, Any]:
        """Return its line, its name and its move as plain data."""
        move = None if self.move is None else move_to_json(self.move)
        return {"line": self.mark.line, "act": self.name, "move": move}
