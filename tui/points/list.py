"""The list of points as a person goes through it, and the text being typed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from armdrive.errors import ArmError, BadRequest
from armdrive.storage.points import Point, check_name
from tui.desk import Desk
from tui.widgets import TypedText

LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.")
"""The characters of a name or a number, never a space."""


class AskedText:
    """A text that is asked for below the list: a name, an opening or a time."""

    def __init__(
        self,
        prompt: str,
        text: str,
        take: Callable[[str], None],
        *,
        offered: bool = False,
        means: Callable[[str], object] = check_name,
        wrong: str = "a letter first, then letters, digits, - _",
    ) -> None:
        """`take` uses the text once it is entered.

        `means` raises `BadRequest` for a text without a meaning, and `wrong` says so at once.
        """
        self.prompt = prompt
        self.take = take
        letters = LETTERS - {"."} if means is check_name else LETTERS
        self.line = TypedText(text, takes=letters.__contains__, offered=offered)
        self._means = means
        self._wrong = wrong

    @property
    def hint(self) -> str:
        """What to say of the text as it stands: that it can be replaced, or what is wrong."""
        if self.line.offered:
            return "  (or type another)"
        try:
            self._means(self.line.text or "a")
        except BadRequest:
            return f"  ({self._wrong})" if self.line.text else ""
        return ""


class PointSelection:
    """The points of the file and the chosen one, which stays chosen as the file changes."""

    def __init__(self, desk: Desk, changed: Callable[[], None]) -> None:
        """`changed` is called when something else is seen to be chosen."""
        self.points: Mapping[str, Point] = {}
        self.naming: AskedText | None = None
        """The text that is being typed."""
        self._chosen = ""
        self._desk = desk
        self._changed = changed
        self._stamp: object = ()

    @property
    def at(self) -> int:
        """The chosen row; the first one if the chosen name no longer exists."""
        return [*self.points].index(self._chosen) if self._chosen in self.points else 0

    @property
    def name(self) -> str:
        """The name of the chosen row; empty of an empty list."""
        return [*self.points][self.at] if self.points else ""

    @property
    def point(self) -> Point | None:
        """The chosen point; None of an empty list."""
        return self.points.get(self.name)

    def move(self, by: int) -> None:
        """Go to another row."""
        if self.points:
            self.choose([*self.points][(self.at + by) % len(self.points)])

    def choose(self, name: str) -> None:
        """Choose a point; one that was just written is in the list once that is read again."""
        self._show(name, self.points)

    def free_name(self) -> str:
        """Return a name that no point has: p1, p2 and so on."""
        number = len(self.points) + 1
        while f"p{number}" in self.points:
            number += 1
        return f"p{number}"

    def reread(self) -> None:
        """Show what stands in the file, when it has changed."""
        points = self._desk.arm.points
        if (stamp := points.stamp) == self._stamp:
            return
        self._stamp = stamp
        try:
            self._show(self._chosen or self.name, points.read())
        except ArmError as error:
            self._desk.message = str(error)

    def _show(self, name: str, points: Mapping[str, Point]) -> None:
        before = (self.name, self.point)
        self._chosen, self.points = name, points
        if before != (self.name, self.point):
            self._changed()

    def ask(self, naming: AskedText) -> None:
        """Ask for a text. Whatever else was begun is taken back."""
        self._desk.disarm("a name is asked for")
        self.naming = naming
