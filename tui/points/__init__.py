"""The points screen: shows saved points, goes to them, and writes a program of them.

Only `go` moves the arm, and no key overwrites a change that another program has made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.errors import BadRequest
from armdrive.errors.printable import printable
from armdrive.motion.plan import audit_opening
from armdrive.moves import JointMove, LineMove, Motion
from armdrive.programs.teaching import GRIPS, TaughtLines
from armdrive.status import Status
from armdrive.storage.points import Point, check_name
from armdrive.text.numbers import number
from kinematics.text import mm_text
from tui.arm_view import SpaceView
from tui.desk import DeskScreen
from tui.keys.keyboard import Keyboard, bindings, short_label
from tui.keys.table import PAUSE, DeskKey, Needs
from tui.move.planned import PlannedMove, preview_text
from tui.points.edit import AskedText, PointSelection, TaughtProgram
from tui.settings import MoveSettings
from tui.widgets import ChoiceList, Span, TypedText, panels

# Lines of the taught program that are shown, the last ones.
LINES_SHOWN = 5

# Rows that do something although nothing has been saved yet.
OF_NONE = ("points-teach", PAUSE)

# Typed for an opening: as far as the fingers are open now.
HERE = "here"


def point_text(point: Point) -> str:
    """Say all that is known of a point."""
    opening = "" if point.opening_mm is None else f"gripper {mm_text(point.opening_mm)} (unchanged)"
    taught = "" if point.taught is None else f"taught {point.taught:%Y-%m-%d %H:%M}"
    return "\n".join(filter(None, (str(point.joints), opening, taught, point.note)))


def program_lines(program: TaughtProgram, keys: Keyboard) -> Iterator[Span]:
    """Show the end of the taught program, and say what the keys append."""
    lines = program.lines
    if program.path is None or not lines:
        return
    first = max(len(lines) - LINES_SHOWN, 0)
    for index, line in enumerate(lines[first:], first + 1):
        yield f"{index:>3}  {printable(line)}", ""
    append, fingers, wait = map(keys.label, ("points-append", "points-fingers", "points-wait"))
    yield f"{append} appends the point, {fingers} the fingers, {wait} a wait", "dim"


def how_text(motion: MoveSettings, keys: Keyboard) -> str:
    """Say how the arm goes to a point."""
    speed = short_label(keys.row("go-speed"))
    return f"{keys.label('line')}: {motion.way}   {speed}: speed {motion.speed:.0%}"


class PointsScreen(DeskScreen):
    """The list, the chosen point, and the arm with the ghost of where it would go."""

    place = "points"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.motion = desk.settings.move
        self.planned = PlannedMove(desk, self.goal)
        self.selection = PointSelection(desk, desk.confirmation.forget)
        self.program = TaughtProgram(desk)
        self.asked: AskedText | None = None
        """The text that is asked for: a name, an opening or a time."""
        # what the keys of several screens do on this one
        self.action_choose = self.selection.move
        self.action_switch_line = self.motion.switch_line
        self.action_change_speed = self.motion.change_speed

    @property
    def typing(self) -> TypedText | None:
        """The text that is asked for."""
        return None if self.asked is None else self.asked.line

    def disarm(self, reason: str) -> None:
        """Drop what is being typed."""
        if self.asked is not None:
            self.asked = None
            self.desk.say(f"what you typed was dropped: {reason}")

    @property
    def works(self) -> Mapping[str, bool]:
        """While a name is typed, keys are its letters; before the first point, few do anything."""
        if self.selection.points and self.asked is None:
            return {}
        rows = (row.id for row in self.desk.keys.rows if row.counts_at(self.place))
        return {row: row in OF_NONE and self.asked is None for row in rows}

    def needs(self, row: DeskKey) -> Needs:
        """Return what a key needs of the arm: nothing while a name is typed."""
        return Needs.NOTHING if self.asked is not None else super().needs(row)

    def goal(self) -> Motion | None:
        """Return the motion to the chosen point."""
        point = self.selection.point
        if point is None:
            return None
        kind = LineMove if self.motion.line else JointMove
        return kind(point.joints, self.motion.speed)

    # -- what is shown ------------------------------------------------------------------------

    def compose_body(self) -> ComposeResult:
        """Lay the middle out."""
        with Horizontal():
            yield from self.arm_panel()
            with VerticalScroll(id="panels", can_focus=False):
                points = ChoiceList("choose", id="list")
                points.border_title = "Points"
                yield points
                yield from panels(
                    begin="Go",
                    chosen="Chosen",
                    how="How it is reached",
                    ahead="What the motion would be",
                    program="Program",
                )

    def show_body(self, status: Status) -> None:
        """Show the list, what is chosen, and what the motion to it would be."""
        self.selection.reread()
        self.program.reread()
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        keys, point = self.desk.keys, self.selection.point
        rows, teach = self.selection.rows, keys.label("points-teach")
        none_yet = f"no points yet: {teach} names the place where the arm stands"
        at = self.selection.at if rows else None
        self.query_one(ChoiceList).show_rows(rows or [none_yet], at)
        told = bool(self.desk.link.hindrance(Needs.POSITION))
        ahead = "" if fresh is None else preview_text(fresh, told=told)
        self.show_panel("chosen", "" if point is None else point_text(point))
        self.show_panel("how", "" if point is None else how_text(self.motion, keys))
        self.show_panel("ahead", self.desk.spoken(ahead))
        asked = "" if self.asked is None else self.asked.shown(keys)
        self.show_panel("begin", asked or self.planned.text(status, fresh))
        panel = self.text("program")
        panel.show_lines(program_lines(self.program, keys))
        panel.display = bool(panel.shown)
        title = printable("" if self.program.path is None else self.program.path.name)
        if panel.border_title != title:
            panel.border_title = title

    # -- keys ---------------------------------------------------------------------------------

    def action_press_go(self) -> None:
        """Take the text that was asked for, or one press of the two that move the arm."""
        if self.asked is not None:
            self.asked.take(self.asked.line.text)
        else:
            self.planned.press()

    def action_delete(self) -> None:
        """Take the chosen row out of the file, after a second press."""
        name, point = self._chosen("delete")
        change = partial(self.desk.arm.points.remove, name, instead_of=point)
        self._confirm("points-delete", f"deletes {name}", change, f"{name} is deleted")

    def action_teach_again(self) -> None:
        """Move the chosen point to where the arm stands, after a second press."""
        name, _ = self._chosen("teach again")

        def change() -> None:
            self._require_standing()
            self.desk.arm.points.teach(name, again=True)

        message = f"{name} is saved again, where the arm stands"
        self._confirm("points-again", f"moves {name} to where the arm stands", change, message)

    def action_teach(self) -> None:
        """Ask for the name of the place where the arm stands."""

        def teach(name: str) -> None:
            self._require_standing()
            self.asked = None
            self.desk.arm.points.teach(name)
            self._named(name, f"{name} is saved, where the arm stands")

        self._ask(AskedText("name of this place", self.selection.free_name(), teach))

    def action_rename(self) -> None:
        """Ask for another name of the chosen point."""
        before, _ = self._chosen("rename")

        def rename(name: str) -> None:
            self.asked = None
            self.desk.arm.points.rename(before, name)
            self._named(name, f"{before} is called {name} now")

        self._ask(AskedText("new name", before, rename, offered=False))

    def action_append(self) -> None:
        """Ask for the program that the chosen point is put at the end of."""
        point, _ = self._chosen("put into a program")

        def append(program: str) -> None:
            line, speed = self.motion.line, self.motion.speed
            self._write(check_name(program), lambda added: added.go(point, line=line, speed=speed))

        last = "taught" if self.program.path is None else self.program.path.stem
        self._ask(AskedText("program to put it at the end of", last, append))

    def action_append_fingers(self) -> None:
        """Ask what the fingers do next in the program."""
        program = self.program.require_name()  # refused before anything is asked

        def append(text: str) -> None:
            grip, speed = self._grip(text), self.motion.speed
            if isinstance(grip, float):
                audit_opening(self.desk.arm.config, grip)
            self._write(program, lambda added: added.fingers(grip, speed=speed))

        self._ask(AskedText("fingers: open, close, grasp, here, or mm", "grasp", append))

    def action_append_wait(self) -> None:
        """Ask how long the program waits next."""
        program = self.program.require_name()

        def append(text: str) -> None:
            time_s = number(text)
            self._write(program, lambda added: added.delay(time_s))

        self._ask(AskedText("seconds to wait", "1", append))

    def action_take_back(self) -> str | None:
        """Delete the last letter that was typed, or take back what was appended last."""
        if self.asked is None:
            return self.program.take_back()
        self.asked.line.erase()
        return None

    def _ask(self, asked: AskedText) -> None:
        """Ask for a text. Whatever else was begun is taken back."""
        self.desk.disarm("a name is asked for")
        self.asked = asked

    def _chosen(self, what: str) -> tuple[str, Point]:
        """Return the chosen point. Raises `BadRequest` where there is none to do this to."""
        if self.selection.point is None:
            raise BadRequest(f"there is no point to {what}")
        return self.selection.name, self.selection.point

    def _confirm(self, row: str, effect: str, change: Callable[[], object], message: str) -> None:
        """Change the file and say so, after a second press."""

        def act() -> None:
            change()
            self.desk.say(message)

        self.desk.confirmation.press(effect, act, row=row)

    def _require_standing(self) -> None:
        """Raise `BadRequest` while the arm is somewhere on the way."""
        link = self.desk.link
        if not link.status.paused:
            link.require_standing()

    def _named(self, name: str, message: str) -> None:
        self.selection.choose(name)
        self.desk.say(message)

    def _grip(self, text: str) -> str | float:
        """Return what the fingers shall do. Raises `BadRequest`."""
        if text != HERE:
            return text if text in GRIPS else number(text)
        opening_mm = self.desk.link.status.gripper_mm
        if opening_mm is None:
            raise BadRequest("the opening of the fingers is unknown: reference the arm")
        return round(opening_mm, 1)

    def _write(self, program: str, write: Callable[[TaughtLines], None]) -> None:
        done = self.program.append(program, write)
        self.asked = None  # only now: what was refused can still be corrected
        self.desk.say(done)
