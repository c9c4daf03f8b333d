"""The list of points and sequences as a person goes through it, and the name being typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from armdrive.errors import ArmError, BadRequest
from armdrive.programs.teaching.steps import parse_step
from armdrive.storage.points import GRIPPER_WORDS, NAME, Point, Step, StepList, Taught
from tui.app import TypedText
from tui.desk import Desk

LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")
"""The characters of a name, never a space."""


_NO_NAME = "a letter first, then letters, digits, - _"

PURPOSES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "teach": ("name of this place", _NO_NAME),
        "rename": ("new name", _NO_NAME),
        "append": ("sequence to put it at the end of", _NO_NAME),
        "to": ("point to go to", "not the name of a point"),
        "gripper": (
            "fingers: open, close, grasp, here, point, or mm",
            "not an opening: type open, close, grasp, here, point, or mm",
        ),
        "wait": ("seconds to wait", "not a time: type seconds"),
    }
)
"""For each kind of text: the prompt, and the complaint about other text."""

STEPS = ("to", "gripper", "wait")
"""The beginning of a step; the rest is typed, a name or a number."""

HERE = "here"
"""Typed for an opening: as far as the fingers are open now."""


class PointNaming:
    """A name that is being typed, and what it is for: one of `PURPOSES`."""

    def __init__(
        self,
        purpose: str,
        text: str = "",
        *,
        take: Callable[[PointNaming], None],
        offered: bool = False,
        changes: bool = False,
    ) -> None:
        """`take` uses the name once it is entered.

        With `changes` the marked step becomes this one; else it is a further one.
        """
        self.purpose = purpose
        self.take = take
        self.changes = changes
        letters = LETTERS | {"."} if purpose in STEPS else LETTERS
        self.line = TypedText(text, takes=letters.__contains__, offered=offered)

    @property
    def text(self) -> str:
        """The name as it stands."""
        return self.line.text

    @property
    def good(self) -> bool:
        """Whether the text is a valid name, or makes a step."""
        if self.purpose not in STEPS:
            return re.fullmatch(NAME, self.text) is not None
        try:
            self.step(0.0)
        except BadRequest:
            return False
        return True

    def step(self, opening_mm: float | None, speed: float = 1.0) -> Step:
        """Return the step that was typed; `opening_mm` is how far the fingers are open now.

        Raises `BadRequest`.
        """
        if self.purpose == "gripper" and self.text == HERE:
            if opening_mm is None:
                raise BadRequest("the opening of the fingers is unknown: reference the arm")
            return Step(gripper=round(opening_mm, 1), speed=speed)
        if wrong := self._no_number():
            raise BadRequest(wrong)
        word = "delay" if self.purpose == "wait" else self.purpose
        step = parse_step(f"{word} {self.text}")
        return step if step.wait_s is not None else replace(step, speed=speed)

    def _no_number(self) -> str:
        """Say what is wrong with a word in the place of a number; nothing of all others."""
        try:
            float(self.text)
        except ValueError:
            if self.purpose == "wait" or (
                self.purpose == "gripper" and self.text not in GRIPPER_WORDS
            ):
                return f"{self.text!r} is {PURPOSES[self.purpose][1]}"
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
        """The chosen row; the first one if the chosen name no longer exists."""
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

    def choosing(self, name: str) -> PointList:
        """Choose a point by its name."""
        return replace(self, chosen=name, of_sequences=False)

    def free_name(self) -> str:
        """Return a name that no point has: p1, p2 and so on."""
        number = len(self.taught.points) + 1
        while f"p{number}" in self.taught.points:
            number += 1
        return f"p{number}"


class PointSelection:
    """The chosen row and the marked step, which follow the file as it changes around them."""

    def __init__(self, desk: Desk, changed: Callable[[PointList], None]) -> None:
        """`changed` is called with the list as it was before, when another one is shown."""
        self.listed = PointList()
        self.naming: PointNaming | None = None
        """The name or number that is being typed."""
        self.written: StepList | None = None
        """The sequence as this desk last wrote it: its steps keep their marks."""
        self._desk = desk
        self._changed = changed
        self._stamp: object = ()
        self._marked: int | None = None

    @property
    def marked(self) -> int | None:
        """The marked step, from 0; None while none is."""
        steps = self.listed.sequence
        if self._marked is None or steps is None or not steps.steps:
            return None
        return min(self._marked, len(steps.steps) - 1)

    def mark(self, step: int | None) -> None:
        """Mark a step, or none."""
        self._marked = step

    def reread(self) -> None:
        """Show what stands in the file, when it has changed."""
        points = self._desk.arm.points
        if (stamp := points.stamp) == self._stamp:
            return
        self._stamp = stamp
        try:
            self.show(self.listed.with_taught(points.read()))
        except ArmError as error:
            self._desk.message = str(error)

    def show(self, listed: PointList) -> None:
        """Show another row, or the same one of another file."""
        known = (self.listed.sequence, self.written)
        if listed.name != self.listed.name or listed.sequence not in known:
            self._marked = None  # what was marked is another step by now
        before, self.listed = self.listed, listed
        self._changed(before)

    def ask(self, naming: PointNaming) -> None:
        """Ask for a name or a number. Whatever else was begun is taken back."""
        self._desk.disarm("a name is asked for")
        self.naming = naming

    def choose_name(self, name: str) -> None:
        """Choose a point that was just written."""
        self.listed = self.listed.choosing(name)
