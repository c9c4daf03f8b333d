"""The list of points and sequences as a person goes through it, and the name being typed. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from armdrive.errors import BadRequest
from armdrive.programs.teaching.sequence import Stepper
from armdrive.storage.points import GRIPPER_WORDS, NAME, Point, Step, StepList, Taught, parse_step
from kinematics.geometry import ArmGeometry
from tui.keys.keyboard import Keyboard
from tui.keys.table import words

LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")
"""What a name is typed with; a space is never one of them."""


_KINDS = {
    "gripper": "opening: type open, close, grasp, here, point, or mm",
    "wait": "time: type seconds",
}

STEPS = ("to", "gripper", "wait")
"""What a step begins with: the rest of it is typed, a name or a number."""

HERE = "here"
"""Typed for an opening: as far as the fingers are open now."""


@dataclass(frozen=True, slots=True)
class PointNaming:
    """A name under way, and what it is for: `teach`, `rename`, `append`, or one of `STEPS`."""

    purpose: str
    text: str = ""
    offered: bool = False
    """Whether nobody has typed it yet: the first letter takes its place."""
    changes: bool = False
    """Whether the marked step becomes this one; else it is a further one."""

    def takes(self, letter: str) -> bool:
        """Tell whether it is typed with this letter."""
        return letter in LETTERS or (letter == "." and self.purpose in STEPS)

    def typed(self, letter: str) -> PointNaming:
        """Add a letter, or begin with it where a name was only offered."""
        return replace(self, text=("" if self.offered else self.text) + letter, offered=False)

    def erased(self) -> PointNaming:
        """Take the last letter away; what was offered is meant then."""
        return replace(self, text=self.text[:-1], offered=False)

    @property
    def good(self) -> bool:
        """Whether it is a name as it stands, or makes a step."""
        if self.purpose not in STEPS:
            return NAME.fullmatch(self.text) is not None
        try:
            self.step(0.0)
        except BadRequest:
            return False
        return True

    def step(self, opening_mm: float | None, speed: float = 1.0) -> Step:
        """Return the step that was typed, with fingers that are so far open now.

        Raises `BadRequest`.
        """
        if self.purpose == "gripper" and self.text == HERE:
            if opening_mm is None:
                raise BadRequest("nobody knows how far the fingers are open: reference the arm")
            return Step(gripper=round(opening_mm, 1), speed=speed)
        if wrong := self._no_number():
            raise BadRequest(wrong)
        step = parse_step(f"{self.purpose} {self.text}")
        return step if step.wait_s is not None else replace(step, speed=speed)

    def _no_number(self) -> str:
        """Say what is wrong with a word in the place of a number; nothing of all others."""
        try:
            float(self.text)
        except ValueError:
            if self.purpose == "wait" or (
                self.purpose == "gripper" and self.text not in GRIPPER_WORDS
            ):
                return f"{self.text!r} is no {_KINDS[self.purpose]}"
        return ""


@dataclass(frozen=True, slots=True)
class PointList:
    """Points first, then sequences; `chosen` is a name, kept while the file changes around it."""

    taught: Taught = field(default_factory=Taught)
    chosen: str = ""
    of_sequences: bool = False

    @property
    def rows(self) -> tuple[tuple[bool, str], ...]:
        """Every row: whether it is a sequence, and its name."""
        points = tuple((False, name) for name in self.taught.points)
        return (*points, *((True, name) for name in self.taught.sequences))

    @property
    def at(self) -> int:
        """The chosen row; the first one where what was chosen has gone."""
        rows = self.rows
        wanted = (self.of_sequences, self.chosen)
        return rows.index(wanted) if wanted in rows else 0

    @property
    def name(self) -> str:
        """The name of the chosen row; empty of an empty list."""
        return self.rows[self.at][1] if self.rows else ""

    @property
    def point(self) -> Point | None:
        """The chosen point, None where a sequence or nothing is chosen."""
        if not self.rows or self.rows[self.at][0]:
            return None
        return self.taught.points[self.name]

    @property
    def sequence(self) -> StepList | None:
        """The chosen sequence, None where a point or nothing is chosen."""
        if not self.rows or not self.rows[self.at][0]:
            return None
        return self.taught.sequences[self.name]

    def moved(self, by: int) -> PointList:
        """Go to another row."""
        if not self.rows:
            return self
        sequence, name = self.rows[(self.at + by) % len(self.rows)]
        return replace(self, chosen=name, of_sequences=sequence)

    def with_taught(self, taught: Taught) -> PointList:
        """Take what the file holds now; the chosen row stays chosen."""
        return replace(self, taught=taught, chosen=self.name, of_sequences=self.point is None)

    def choosing(self, name: str, *, sequence: bool = False) -> PointList:
        """Choose a row by its name."""
        return replace(self, chosen=name, of_sequences=sequence)

    def free_name(self) -> str:
        """Return a name that no point has: p1, p2 and so on."""
        number = len(self.taught.points) + 1
        while f"p{number}" in self.taught.points:
            number += 1
        return f"p{number}"


# What the points screen says: the list, the chosen point or sequence, the name being typed.

NAME_WIDTH = 16
STEPS_SHOWN = 9
"""Steps of a sequence that are shown about the next one."""

_PURPOSES = {
    "teach": "name of this place",
    "rename": "new name",
    "append": "sequence to put it at the end of",
    "to": "point to go to",
    "gripper": "fingers: open, close, grasp, here, point, or mm",
    "wait": "seconds to wait",
}
_WRONG = {
    "to": "no name of a point",
    "gripper": "none of these",
    "wait": "no time",
}
_WRONG_NAME = "a letter first, then letters, digits, - _"


def list_text(listed: PointList, arm: ArmGeometry, height: int, keys: Keyboard) -> str:
    """Lay the list out, as many rows as there is room for about the chosen one."""
    rows = listed.rows
    if not rows:
        return f"no points yet: {keys.label('points-teach')} names the place where the arm stands"
    first = max(min(listed.at - height // 2, len(rows) - height), 0)
    lines = []
    for index, (is_sequence, name) in enumerate(rows[first : first + height], first):
        mark = ">" if index == listed.at else " "
        if is_sequence:
            said = f"sequence, {len(listed.taught.sequences[name].steps)} steps"
        else:
            said = _tip(listed.taught.points[name], arm)
        lines.append(f"{mark} {name[:NAME_WIDTH]:<{NAME_WIDTH}} {said}")
    return "\n".join(lines)


def _tip(point: Point, arm: ArmGeometry) -> str:
    x, y, z = arm.points(point.joints)[-1]
    return f"x {x:.0f}  y {y:.0f}  z {z:.0f}"


def point_text(point: Point) -> str:
    """Say all that is known of a point."""
    lines = [
        "  ".join(f"{words(name)} {angle:.1f}°" for name, angle in point.joints.deg.items()),
    ]
    if point.opening_mm is not None:
        lines.append(f"fingers {point.opening_mm:.1f} mm, which stay as they are")
    taught = "" if point.taught is None else f"taught {point.taught:%Y-%m-%d %H:%M}"
    lines += [part for part in (taught, point.note) if part]
    return "\n".join(lines)


def sequence_text(
    stepper: Stepper, keys: Keyboard, *, stepping: bool, marked: int | None = None
) -> str:
    """Lay the steps out about the next or the marked one, and say what the keys would do."""
    return "\n".join(_sequence_lines(stepper, keys, stepping=stepping, marked=marked))


def _sequence_lines(
    stepper: Stepper, keys: Keyboard, *, stepping: bool, marked: int | None
) -> Iterator[str]:
    total, middle = len(stepper.steps), stepper.at if marked is None else marked
    first = max(min(middle - STEPS_SHOWN // 2, total - STEPS_SHOWN), 0)
    for index, step in enumerate(stepper.steps[first : first + STEPS_SHOWN], first):
        mark = (">" if index == stepper.at else " ") + ("*" if index == marked else " ")
        yield f"{mark}{index + 1:>3} {'done ' * (index < stepper.at)}{step}"
    if marked is not None:
        drop, sooner = keys.label("points-step-drop"), keys.label("points-step-sooner")
        later, change = keys.label("points-step-later"), keys.label("points-step-change")
        yield f"* {change} changes it, {drop} twice: out; {sooner} {later}: sooner, later"
    grip, wait = keys.label("points-grip"), keys.label("points-wait")
    yield f"{grip} adds fingers, {wait} a wait"
    if stepper.at == total:
        yield f"at its end: {keys.label('points-rewind')} begins anew"
    switch = keys.label("points-stepping")
    if not stepping:
        yield f"{switch} lets single steps be made"
        return
    yield f"STEPPING [{switch}]  {keys.label('points-forward')} next step"
    if stepper.before is not None:
        yield f"{keys.label('points-backward')} back to {stepper.before[1]}"


def how_text(*, line: bool, speed: float, keys: Keyboard) -> str:
    """Say how a point is gone to."""
    way = "straight line" if line else "joint motion"
    slower, faster = keys.label("points-slower"), keys.label("points-faster")
    return f"{way} [{keys.label('points-line')}]  speed {speed:.0%} [{slower} {faster}]"


def naming_text(naming: PointNaming, keys: Keyboard) -> str:
    """Show the name as it is typed."""
    enter, stop = keys.label("points-go"), keys.label("stop")
    reason = _WRONG.get(naming.purpose, _WRONG_NAME)
    wrong = "" if naming.good or not naming.text else f"  ({reason})"
    said = "  (or type another)" if naming.offered else wrong
    return f"{_PURPOSES[naming.purpose]}: {naming.text}_{said}\n{enter} takes it, {stop} drops it"
