"""Programs written as they are taught, line by line, or recorded from an arm's motions.

A recorder adds a line wherever the arm or its fingers come to rest. It is given the arm's statuses
and their times; it has no clock and no arm. Places where the arm rests only for a moment, such as
between two jogs, do not count. Units: deg, mm, s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from armdrive.errors import BadRequest, NotReferenced
from armdrive.moves import REST_S
from armdrive.programs.language.syntax import (
    NAME,
    Do,
    Literal,
    Tree,
    every,
    names_of,
)
from armdrive.programs.language.words import FUNCTIONS, RESERVED
from armdrive.programs.program import read_program
from armdrive.status import BELIEVED_WORDS
from armdrive.storage.points import SAME_OPENING_MM, Point
from kinematics.spaces import Joints
from kinematics.text import plain

# The lines of a program as they are taught, one after another.

# What the fingers do, besides going to an opening in mm.
GRIPS = ("open", "close", "grasp")


class TaughtLines:
    """Lines that follow a program, or that begin one.

    `speed` is the speed at the end of what is written so far, None if only a run can tell. `own`
    are the names that the program defines, in lower case: they hide points of the same name.
    """

    def __init__(self, speed: float | None = 1.0, own: frozenset[str] = frozenset()) -> None:
        self._speed = speed
        self._own = own
        self._lines: list[str] = []

    @classmethod
    def after(cls, text: str, file: str = "") -> TaughtLines:
        """Return what writes lines at the end of a program. Raises `ProgramError`."""
        tree = read_program(text, file).tree
        return cls(_speed_at_end(tree), names_of(tree).variables)

    @property
    def text(self) -> str:
        """All lines so far."""
        return "".join(f"{line}\n" for line in self._lines)

    def go(self, point: str, *, line: bool = False, speed: float = 1.0) -> None:
        """Go to a point, by a joint motion or along a straight line."""
        self._set_speed(speed)
        self._lines.append(f"{'move_line' if line else 'move'} {self._place(point)}")

    def fingers(self, grip: str | float, *, speed: float = 1.0) -> None:
        """Move the fingers to an opening in mm, or as one of `GRIPS` says."""
        if grip != "grasp":
            self._set_speed(speed)
        if isinstance(grip, str):
            if grip not in GRIPS:
                raise BadRequest(f"the fingers {', '.join(GRIPS)}, or go to mm, not {grip!r}")
            self._lines.append("grasp" if grip == "grasp" else f"{grip}_now")
        else:
            self._lines.append(f"open_now {plain(grip, 3)}" if grip else "close_now")

    def delay(self, time_s: float) -> None:
        """Let time pass."""
        self._lines.append(f"delay {plain(time_s, 3)}")

    def _set_speed(self, speed: float) -> None:
        if speed != self._speed:
            self._lines.append(f"speed {plain(100.0 * speed, 3)}%")
            self._speed = speed

    def _place(self, point: str) -> str:
        other = (RESERVED - FUNCTIONS.keys()) | self._own  # a function has brackets behind it
        is_name = NAME.fullmatch(point) and point.lower() not in other
        return point if is_name else f'taught("{point}")'


def _speed_at_end(tree: Tree) -> float | None:
    """Return the speed after the last line; None if it depends on values or on the way there."""
    lines = [each for each in every(tree.body) if isinstance(each, Do) and each.word == "speed"]
    if not lines:
        return 1.0
    certain = all(any(line is each for each in tree.body) for line in lines)
    match lines[-1].arguments[0]:
        case Literal(value=float(speed)) if certain:
            return speed
        case _:
            return None


# The largest difference between equal postures: less than a step of any of these arms.
SAME_DEG = 0.05

RESTING = "standby"


@dataclass(frozen=True, slots=True)
class SeenPosture:
    """The posture in a status; `joints` is None if the arm does not rest."""

    joints: Joints | None
    opening_mm: float | None = None
    gripping: bool = False


@dataclass(frozen=True, slots=True)
class Choices:
    """The options of a recording.

    `line` and `speed` are those of every motion to a point; with `waits` the rests become delays.
    """

    line: bool = False
    speed: float = 1.0
    waits: bool = False
    rest_s: float = REST_S


def seen_in(view: Mapping[str, Any], names: tuple[str, ...]) -> SeenPosture:
    """Read a status as `armdrive watch` prints it. Raises `NotReferenced` without a position."""
    joints = view.get("joints")
    trust = str(view.get("trust"))
    if trust not in BELIEVED_WORDS or joints is None:
        raise NotReferenced(
            f"the arm has no trusted position: it is {trust} "
            f"({view.get('trust_reason', '')}). Home it, then record"
        )
    if view.get("state") != RESTING or view.get("paused"):
        return SeenPosture(None)
    angles = (float(joints[f"{name}_deg"]) for name in names)
    opening = view.get("gripper_mm")
    return SeenPosture(
        Joints.of(*angles, names=names),
        None if opening is None else float(opening),
        bool(view.get("gripping")),
    )


class ProgramRecorder:
    """Makes a program of statuses; its points are named `NAME_1` and so on."""

    def __init__(self, name: str, choices: Choices) -> None:
        self.name = name
        self.points: dict[str, Point] = {}
        self._lines = TaughtLines()
        self._choices = choices
        self._standing: SeenPosture | None = None
        self._since_s = 0.0
        self._kept: SeenPosture | None = None

    @property
    def text(self) -> str:
        """The lines recorded so far."""
        return self._lines.text

    def see(self, seen: SeenPosture, now_s: float) -> bool:
        """Take the present status; return whether it completes a line."""
        before = self._standing
        if before is not None and seen.joints is not None and _same(before, seen):
            return False
        made = before is not None and self._rested(before, now_s)
        self._standing = None if seen.joints is None else seen
        self._since_s = now_s
        return made

    def end(self, now_s: float) -> bool:
        """End with the place where the arm stands, however briefly it has rested there."""
        before, self._standing = self._standing, None
        return before is not None and self._rested(before, now_s, enough=True)

    def _rested(self, at: SeenPosture, now_s: float, *, enough: bool = False) -> bool:
        rested_s = now_s - self._since_s
        if rested_s < self._choices.rest_s and not enough:
            return False
        went, gripped = self._go(at), self._fingers(at)
        if not (went or gripped):
            return False
        if self._choices.waits and not enough:
            self._lines.delay(round(rested_s, 1))
        self._kept = at
        return True

    def _go(self, at: SeenPosture) -> bool:
        """Write the motion to a place, if the arm has moved; a known place keeps its name."""
        joints = at.joints
        if joints is None or (self._kept is not None and _there(self._kept, at)):
            return False
        name = next((n for n, each in self.points.items() if _near(each.joints, joints)), "")
        if not name:
            name = f"{self.name}_{len(self.points) + 1}"
            self.points[name] = Point(joints, at.opening_mm)
        self._lines.go(name, line=self._choices.line, speed=self._choices.speed)
        return True

    def _fingers(self, at: SeenPosture) -> bool:
        """Write what the fingers did, if they have moved."""
        kept = self._kept
        if at.opening_mm is None or (kept is not None and _held_alike(kept, at)):
            return False
        grip = "grasp" if at.gripping else round(at.opening_mm, 1)
        self._lines.fingers(grip, speed=self._choices.speed)
        return True


def _same(a: SeenPosture, b: SeenPosture) -> bool:
    return _there(a, b) and _held_alike(a, b)


def _there(a: SeenPosture, b: SeenPosture) -> bool:
    return a.joints is not None and b.joints is not None and _near(a.joints, b.joints)


def _near(a: Joints, b: Joints) -> bool:
    pairs = zip(a.deg.values(), b.deg.values(), strict=True)
    return all(abs(one - other) <= SAME_DEG for one, other in pairs)


def _held_alike(a: SeenPosture, b: SeenPosture) -> bool:
    if a.gripping and b.gripping:  # the object stays gripped while the fingers press
        return True
    if a.opening_mm is None or b.opening_mm is None:
        return a.opening_mm is b.opening_mm
    return a.gripping == b.gripping and abs(a.opening_mm - b.opening_mm) < SAME_OPENING_MM
