"""The points as a person goes through them, the text that is asked for, and the taught program."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from armdrive.errors import ArmError, BadRequest, PointsChanged
from armdrive.programs.language import ENDING
from armdrive.programs.teaching import TaughtLines
from armdrive.storage.files import DISK, NotWanted, replace_durably, stamp_of
from armdrive.storage.points import Point
from armdrive.text.reading import is_there, read_text
from kinematics.geometry import ArmGeometry
from tui.desk import Desk
from tui.keys.keyboard import Keyboard
from tui.widgets import TypedText

NAME_WIDTH = 16

# The characters of a name or a number, never a space.
LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.")


class AskedText:
    """A text that is asked for below the list: a name, an opening or a time."""

    def __init__(
        self,
        prompt: str,
        text: str,
        take: Callable[[str], None],
        *,
        offered: bool = True,
    ) -> None:
        """`take` uses the text once it is entered, and raises `BadRequest` if it has no meaning."""
        self.take = take
        self.line = TypedText(text, takes=LETTERS.__contains__, offered=offered)
        self._prompt = prompt

    def shown(self, keys: Keyboard) -> str:
        """Show the text as it is typed."""
        enter, stop = keys.label("go"), keys.label("stop")
        hint = "  (or type another)" if self.line.offered else ""
        return f"{self._prompt}: {self.line.text}_{hint}\n{enter} takes it, {stop} drops it"


def list_rows(points: Mapping[str, Point], arm: ArmGeometry) -> list[str]:
    """Return a row for each point."""
    rows = []
    for name, point in points.items():
        x, y, z = arm.points(point.joints)[-1]
        rows.append(f"{name[:NAME_WIDTH]:<{NAME_WIDTH}} x {x:.0f}  y {y:.0f}  z {z:.0f}")
    return rows


class PointSelection:
    """The points of the file and the chosen one, which stays chosen as the file changes."""

    def __init__(self, desk: Desk, changed: Callable[[], None]) -> None:
        """`changed` is called when something else is seen to be chosen."""
        self.points: Mapping[str, Point] = {}
        self.rows: list[str] = []
        """A row of the list for each point."""
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
            self.rows = list_rows(self.points, self._desk.arm.model.arm)
        except ArmError as error:
            self._desk.message = str(error)

    def _show(self, name: str, points: Mapping[str, Point]) -> None:
        before = (self.name, self.point)
        self._chosen, self.points = name, points
        if before != (self.name, self.point):
            self._changed()


class TaughtProgram:
    """The program that points are appended to, line by line."""

    def __init__(self, desk: Desk) -> None:
        self.path: Path | None = None
        """The file that was appended to last; None if none was."""
        self.lines: tuple[str, ...] = ()
        """Its lines, as they were read last."""
        self._desk = desk
        self._stamp: object = None
        self._undo: tuple[str, str] | None = None

    def reread(self) -> None:
        """Show what stands in the file, when it has changed."""
        if self.path is None or (stamp := stamp_of(self.path)) == self._stamp:
            return
        self._stamp = stamp
        try:
            self.lines = tuple(_text_of(self.path).splitlines())
        except ArmError as error:
            self._desk.message = str(error)

    def append(self, name: str, write: Callable[[TaughtLines], None]) -> str:
        """Write lines at the end of a program of the desk's folder; return what was done."""
        path = self._desk.programs / f"{name}{ENDING}"
        before = _text_of(path)
        added = TaughtLines.after(before, path.name)
        write(added)
        after = before + "\n" * (not before.endswith("\n") and bool(before)) + added.text
        self._replace(path, before, after)
        self.path, self._undo = path, (before, after)
        return f"{path.name}, line {len(after.splitlines())}: {_in_one_line(added.text)}"

    def require_name(self) -> str:
        """Return the name of the program. Raises `BadRequest` where none was appended to yet."""
        if self.path is None:
            key = self._desk.keys.label("points-append")
            raise BadRequest(f"{key} on a point begins a program")
        return self.path.stem

    def take_back(self) -> str:
        """Take back what was appended last; return what was done."""
        if self.path is None or self._undo is None:
            raise BadRequest("there is no line to take back")
        before, after = self._undo
        self._replace(self.path, after, before)
        self._undo = None
        return f"taken back from {self.path.name}: {_in_one_line(after.removeprefix(before))}"

    def _replace(self, path: Path, seen: str, text: str) -> None:
        try:
            replace_durably(DISK, path, text.encode("utf-8"), wanted=lambda: _text_of(path) == seen)
        except NotWanted:
            raise PointsChanged(f"{path.name} has changed meanwhile; nothing was written") from None


def _text_of(path: Path) -> str:
    return read_text(path, "the program", BadRequest) if is_there(path) else ""


def _in_one_line(lines: str) -> str:
    return " / ".join(lines.strip().splitlines())
