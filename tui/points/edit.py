"""The points as a person goes through them, and the keys that change files: points and a program.

None of them moves the arm, and none overwrites a change that another program has made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from armdrive.errors import ArmError, BadRequest, PointsChanged
from armdrive.motion.plan import audit_opening
from armdrive.programs.language import ENDING
from armdrive.programs.teaching.recording import GRIPS, TaughtLines
from armdrive.storage.files import DISK, NotWanted, replace_durably, stamp_of
from armdrive.storage.points import Point, check_name
from armdrive.text.numbers import number
from armdrive.text.reading import is_there, read_text
from tui.desk import Desk
from tui.settings import MoveSettings
from tui.widgets import TypedText

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


# Typed for an opening: as far as the fingers are open now.
HERE = "here"


class PointEdits:
    """Changes of the chosen point, and lines of a program that go to it."""

    def __init__(self, desk: Desk, selection: PointSelection, motion: MoveSettings) -> None:
        self.program = TaughtProgram(desk)
        self._desk = desk
        self._selection = selection
        self._motion = motion

    def delete(self) -> None:
        """Take the chosen row out of the file, after a second press."""
        name, point = self._chosen("delete")
        change = partial(self._desk.arm.points.remove, name, instead_of=point)
        self._confirm("points-delete", f"deletes {name}", change, f"{name} is deleted")

    def teach_again(self) -> None:
        """Move the chosen point to where the arm stands, after a second press."""
        name, _ = self._chosen("teach again")

        def change() -> None:
            self._require_standing()
            self._desk.arm.points.teach(name, again=True)

        message = f"{name} is saved again, where the arm stands"
        self._confirm("points-again", f"moves {name} to where the arm stands", change, message)

    def teach(self) -> None:
        """Ask for the name of the place where the arm stands."""
        free = self._selection.free_name()
        self._selection.ask(AskedText("name of this place", free, self._teach, offered=True))

    def rename(self) -> None:
        """Ask for another name of the chosen point."""
        name, _ = self._chosen("rename")
        self._selection.ask(AskedText("new name", name, partial(self._rename, name)))

    def append(self) -> None:
        """Ask for the program that the chosen point is put at the end of."""
        self._chosen("put into a program")
        last = "taught" if self.program.path is None else self.program.path.stem
        prompt = "program to put it at the end of"
        self._selection.ask(AskedText(prompt, last, self._append, offered=True))

    def append_fingers(self) -> None:
        """Ask what the fingers do next in the program."""
        self.program.require_name()  # refused before anything is asked
        self._selection.ask(
            AskedText(
                "fingers: open, close, grasp, here, or mm",
                "grasp",
                self._append_fingers,
                offered=True,
                means=self._grip,
                wrong="not an opening: type open, close, grasp, here, or mm",
            )
        )

    def append_wait(self) -> None:
        """Ask how long the program waits next."""
        self.program.require_name()
        asked = AskedText("seconds to wait", "1", self._append_wait, offered=True, means=number,
                          wrong="not a time: type seconds")  # fmt: skip
        self._selection.ask(asked)

    def erase(self) -> str | None:
        """Delete the last letter that was typed, or take back what was appended last."""
        if self._selection.naming is None:
            return self.program.take_back()
        self._selection.naming.line.erase()
        return None

    def move_there(self) -> None:
        """Ask for the chosen point on the move screen, to change it there."""
        _, point = self._chosen("change")
        self._desk.goal = point.joints
        self._desk.screens.show("move")

    def _chosen(self, what: str) -> tuple[str, Point]:
        """Return the chosen point. Raises `BadRequest` where there is none to do this to."""
        if self._selection.point is None:
            raise BadRequest(f"there is no point to {what}")
        return self._selection.name, self._selection.point

    def _confirm(self, row: str, effect: str, change: Callable[[], object], message: str) -> None:
        """Change the file and say so, after a second press."""

        def act() -> None:
            change()
            self._desk.say(message)

        self._desk.confirmation.press(effect, act, row=row)

    def _require_standing(self) -> None:
        """Raise `BadRequest` while the arm is somewhere on the way."""
        link = self._desk.link
        if not link.status.paused:
            link.require_standing()

    def _teach(self, name: str) -> None:
        self._require_standing()
        self._selection.naming = None
        self._desk.arm.points.teach(name)
        self._desk.say(f"{name} is saved, where the arm stands")
        self._selection.choose(name)

    def _rename(self, before: str, name: str) -> None:
        self._selection.naming = None
        self._desk.arm.points.rename(before, name)
        self._desk.say(f"{before} is called {name} now")
        self._selection.choose(name)

    def _append(self, program: str) -> None:
        point, motion = self._selection.name, self._motion
        self._write(
            check_name(program),
            lambda lines: lines.go(point, line=motion.line, speed=motion.speed),
        )

    def _append_fingers(self, text: str) -> None:
        grip = self._grip(text)
        if isinstance(grip, float):
            audit_opening(self._desk.arm.config, grip)
        self._write(
            self.program.require_name(), lambda lines: lines.fingers(grip, speed=self._motion.speed)
        )

    def _grip(self, text: str) -> str | float:
        """Return what the fingers shall do. Raises `BadRequest`."""
        if text != HERE:
            return text if text in GRIPS else number(text)
        opening_mm = self._desk.link.status.gripper_mm
        if opening_mm is None:
            raise BadRequest("the opening of the fingers is unknown: reference the arm")
        return round(opening_mm, 1)

    def _append_wait(self, text: str) -> None:
        time_s = number(text)
        self._write(self.program.require_name(), lambda lines: lines.delay(time_s))

    def _write(self, program: str, write: Callable[[TaughtLines], None]) -> None:
        done = self.program.append(program, write)
        self._selection.naming = None  # only now: what was refused can still be corrected
        self._desk.say(done)
