"""The points screen: shows saved points, goes to them, and writes a program of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.errors.printable import printable
from armdrive.moves import JointMove, LineMove, Motion
from armdrive.status import Status
from armdrive.storage.points import Point
from kinematics.geometry import ArmGeometry
from kinematics.text import mm_text
from tui.arm_view import SpaceView
from tui.desk import DeskScreen
from tui.keys.keyboard import Keyboard, bindings
from tui.keys.table import PAUSE, DeskKey, Needs
from tui.move.planned import PlannedMove, short_text
from tui.points.edit import AskedText, PointEdits, PointSelection, TaughtProgram
from tui.settings import MoveSettings
from tui.widgets import ChoiceList, Span, TypedText, panels

NAME_WIDTH = 16
# Lines of the taught program that are shown, the last ones.
LINES_SHOWN = 5


def list_rows(points: Mapping[str, Point], arm: ArmGeometry) -> list[str]:
    """Return a row for each point."""
    return [
        f"{name[:NAME_WIDTH]:<{NAME_WIDTH}} {_tip(point, arm)}" for name, point in points.items()
    ]


def none_yet(keys: Keyboard) -> str:
    """Say how the first point is made."""
    return f"no points yet: {keys.label('points-teach')} names the place where the arm stands"


def _tip(point: Point, arm: ArmGeometry) -> str:
    x, y, z = arm.points(point.joints)[-1]
    return f"x {x:.0f}  y {y:.0f}  z {z:.0f}"


def point_text(point: Point) -> str:
    """Say all that is known of a point."""
    lines = [str(point.joints)]
    if point.opening_mm is not None:
        lines.append(f"gripper {mm_text(point.opening_mm)} (unchanged)")
    taught = "" if point.taught is None else f"taught {point.taught:%Y-%m-%d %H:%M}"
    lines += [part for part in (taught, point.note) if part]
    return "\n".join(lines)


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
    slower, faster = keys.label("go-slower"), keys.label("go-faster")
    return (
        f"{keys.label('points-line')}: {motion.way}   {slower} {faster}: speed {motion.speed:.0%}"
    )


def naming_text(naming: AskedText, keys: Keyboard) -> str:
    """Show the text as it is typed."""
    enter, stop = keys.label("points-go"), keys.label("stop")
    return f"{naming.prompt}: {naming.line.text}_{naming.hint}\n{enter} takes it, {stop} drops it"


# Rows that do something although nothing has been saved yet.
OF_NONE = ("points-teach", PAUSE)


class PointsScreen(DeskScreen):
    """The list, the chosen point, and the arm with the ghost of where it would go."""

    place = "points"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.planned = PlannedMove(desk, self.goal)
        self.selection = PointSelection(desk, desk.confirmation.forget)
        self.motion = desk.settings.move
        self.points = PointEdits(desk, self.selection, self.motion)

    @property
    def typing(self) -> TypedText | None:
        """The text that is asked for."""
        return None if self.selection.naming is None else self.selection.naming.line

    def disarm(self, reason: str) -> None:
        """Drop what is being typed."""
        if self.selection.naming is not None:
            self.selection.naming = None
            self.desk.say(f"what you typed was dropped: {reason}")

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

    def goal(self) -> Motion | None:
        """Return the motion to the chosen point."""
        point = self.selection.point
        if point is None:
            return None
        kind = LineMove if self.motion.line else JointMove
        return kind(point.joints, self.motion.speed)

    def show_body(self, status: Status) -> None:
        """Show the list, what is chosen, and what the motion to it would be."""
        self.selection.reread()
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        keys, arm = self.desk.keys, self.desk.arm.model.arm
        rows, point = list_rows(self.selection.points, arm), self.selection.point
        at = self.selection.at if rows else None
        self.query_one(ChoiceList).show_rows(rows or [none_yet(keys)], at)
        self.show_panel("chosen", "" if point is None else point_text(point))
        self.show_panel("how", "" if point is None else how_text(self.motion, keys))
        told = bool(self.desk.link.hindrance(Needs.POSITION))
        ahead = short_text(fresh, told=told) if fresh is not None else ""
        self.show_panel("ahead", self.desk.spoken(ahead))
        self.show_panel("begin", self._begin_text(status, fresh is not None))
        self._show_program()

    def _show_program(self) -> None:
        panel, program = self.text("program"), self.points.program
        program.reread()
        panel.show_lines(program_lines(program, self.desk.keys))
        panel.display = bool(panel.shown)
        if program.path is not None:
            panel.border_title = printable(program.path.name)

    def _begin_text(self, status: Status, fresh: bool) -> str:
        if self.selection.naming is not None:
            return naming_text(self.selection.naming, self.desk.keys)
        if again := self.desk.confirmation.again:
            return again
        return self.planned.text(status, self.planned.preview if fresh else None)

    @property
    def works(self) -> Mapping[str, bool]:
        """While a name is typed, keys are its letters; before the first point, few do anything."""
        naming = self.selection.naming is not None
        if self.selection.points and not naming:
            return {}
        rows = (row.id for row in self.desk.keys.rows if row.counts_at(self.place))
        return {row: row in OF_NONE and not naming for row in rows}

    def needs(self, row: DeskKey) -> Needs:
        """Return what a key needs of the arm: nothing while a name is typed."""
        return Needs.NOTHING if self.selection.naming is not None else super().needs(row)

    # -- keys ---------------------------------------------------------------------------------

    def action_choose(self, by: int) -> None:
        """Go to another row."""
        self.selection.move(by)

    def action_press_go(self) -> None:
        """Take the name, or one press of the two that move the arm."""
        if (naming := self.selection.naming) is not None:
            naming.take(naming.line.text)
        else:
            self.planned.press()
