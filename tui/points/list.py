"""The list of points as a person goes through it, and the text being typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from armdrive.errors import ArmError, BadRequest
from armdrive.programs.teaching.recording import GRIPS
from armdrive.storage.points import NAME, Point
from armdrive.text.numbers import number
from tui.desk import Desk
from tui.widgets import TypedText

LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")
"""The characters of a name, never a space."""


_NO_NAME = "a letter first, then letters, digits, - _"

PURPOSES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "teach": ("name of this place", _NO_NAME),
        "rename": ("new name", _NO_NAME),
        "append": ("program to put it at the end of", _NO_NAME),
        "fingers": (
            "fingers: open, close, grasp, here, or mm",
            "not an opening: type open, close, grasp, here, or mm",
        ),
        "wait": ("seconds to wait", "not a time: type seconds"),
    }
)
"""For each kind of text: the prompt, and the complaint about other text."""

HERE = "here"
"""Typed for an opening: as far as the fingers are open now."""


class PointNaming:
    """A name, an opening or a time that is being typed, and what it is for: one of `PURPOSES`."""

    def __init__(
        self,
        purpose: str,
        text: str = "",
        *,
        take: Callable[[PointNaming], None],
        offered: bool = False,
    ) -> None:
        """`take` uses the text once it is entered."""
        self.purpose = purpose
        self.take = take
        letters = LETTERS if self._is_name else LETTERS | {"."}
        self.line = TypedText(text, takes=letters.__contains__, offered=offered)

    @property
    def text(self) -> str:
        """The text as it stands."""
        return self.line.text

    @property
    def good(self) -> bool:
        """Whether the text is a valid name, an opening or a time."""
        if self._is_name:
            return re.fullmatch(NAME, self.text) is not None
        try:
            _ = self.time_s if self.purpose == "wait" else self.grip(0.0)
        except BadRequest:
            return False
        return True

    @property
    def time_s(self) -> float:
        """The time that was typed. Raises `BadRequest`."""
        return number(self.text)

    def grip(self, opening_mm: float | None) -> str | float:
        """Return what the fingers shall do; `opening_mm` is how far they are open now.

        Raises `BadRequest`.
        """
        if self.text == HERE:
            if opening_mm is None:
                raise BadRequest("the opening of the fingers is unknown: reference the arm")
            return round(opening_mm, 1)
        return self.text if self.text in GRIPS else number(self.text)

    @property
    def _is_name(self) -> bool:
        return self.purpose not in ("fingers", "wait")


@dataclass(frozen=True, slots=True)
class PointList:
    """The points by name; `chosen` is a name, kept while the file changes around it."""

    points: Mapping[str, Point] = field(default_factory=dict)
    chosen: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """Every name, in the order of the file."""
        return tuple(self.points)

    @property
    def at(self) -> int:
        """The chosen row; the first one if the chosen name no longer exists."""
        return self.names.index(self.chosen) if self.chosen in self.points else 0

    @property
    def name(self) -> str:
        """The name of the chosen row; empty of an empty list."""
        return self.names[self.at] if self.points else ""

    @property
    def point(self) -> Point | None:
        """The chosen point; None of an empty list."""
        return self.points.get(self.name)

    def moved(self, by: int) -> PointList:
        """Go to another row."""
        if not self.points:
            return self
        return replace(self, chosen=self.names[(self.at + by) % len(self.points)])

    def with_points(self, points: Mapping[str, Point]) -> PointList:
        """Take what the file holds now; the chosen row stays chosen."""
        return replace(self, points=points, chosen=self.name)

    def free_name(self) -> str:
        """Return a name that no point has: p1, p2 and so on."""
        number = len(self.points) + 1
        while f"p{number}" in self.points:
            number += 1
        return f"p{number}"


class PointSelection:
    """The chosen row, which follows the file as it changes around it."""

    def __init__(self, desk: Desk, changed: Callable[[], None]) -> None:
        """`changed` is called when something else is seen to be chosen."""
        self.listed = PointList()
        self.naming: PointNaming | None = None
        """The text that is being typed."""
        self._desk = desk
        self._changed = changed
        self._stamp: object = ()

    def reread(self) -> None:
        """Show what stands in the file, when it has changed."""
        points = self._desk.arm.points
        if (stamp := points.stamp) == self._stamp:
            return
        self._stamp = stamp
        try:
            self.show(self.listed.with_points(points.read()))
        except ArmError as error:
            self._desk.message = str(error)

    def show(self, listed: PointList) -> None:
        """Show another row, or the same one of another file."""
        before, self.listed = self.listed, listed
        if (before.name, before.point) != (listed.name, listed.point):
            self._changed()

    def ask(self, naming: PointNaming) -> None:
        """Ask for a text. Whatever else was begun is taken back."""
        self._desk.disarm("a name is asked for")
        self.naming = naming

    def choose_name(self, name: str) -> None:
        """Choose a point that was just written."""
        self.listed = replace(self.listed, chosen=name)
