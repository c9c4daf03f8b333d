"""The points screen: named places, and sequences over them, seen, gone to and stepped through."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.moves import JointMove, LineMove, Motion
from armdrive.status import Status
from armdrive.storage.points import Point, StepList
from tui.arm_view import SpaceView
from tui.choices import ChoiceList
from tui.keys.keyboard import bindings
from tui.keys.presses import Confirmation
from tui.move import text as move_text
from tui.move.planned import PlannedMove
from tui.painting import Span
from tui.points import text as point_text
from tui.points.edit import PointEdits, PointMotion, StepEdits
from tui.points.list import NameEntry, PointList, PointSelection
from tui.points.run import SequenceRun
from tui.screens import DeskScreen, panels

OF_POINTS = ("again", "rename", "edit", "line", "slower", "faster", "append")
OF_SEQUENCES = ("step-next", "grip", "wait", "stepping", "forward", "backward", "rewind")
"""Rows of the table of keys that are about the one alone, or mostly."""


class PointsScreen(DeskScreen):
    """The list, the chosen point or sequence, and the arm with the ghost of where it would go."""

    place = "points"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.confirmation = Confirmation(desk.clock)
        self.planned = PlannedMove(desk, self.goal)
        self.sequence = SequenceRun(desk)
        self.selection = PointSelection(desk, self._selection_changed)
        self.names = NameEntry(desk, self.disarm)
        self.steps = StepEdits(
            desk, self.selection, self.names, self.confirmation, self.sequence.says_busy
        )
        self.motion = PointMotion(desk, self.steps, self.planned.forget_press)
        self.points = PointEdits(desk, self.selection, self.names, self.confirmation, self.motion)

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - as every screen
        """Let nothing go on that is not under way; a sequence ends after its step."""
        self.planned.forget_press()
        self.names.clear()
        self.confirmation.forget()
        self.sequence.disarm()

    def _selection_changed(self, before: PointList) -> None:
        """Take back what was asked for while something else was seen to be chosen."""
        listed = self.selection.listed
        if _shown(before) != _shown(listed):
            self.planned.forget_press()
            self.confirmation.forget()
        self.sequence.follow(listed, same_row=before.name == listed.name)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out."""
        with Horizontal():
            yield from self.arm_panel()
            with VerticalScroll(id="panels", can_focus=False):
                points = ChoiceList(self._choose, id="list")
                points.border_title = "Points and sequences"
                yield points
                yield from panels(
                    begin="Go",
                    chosen="Chosen",
                    how="How it is reached",
                    ahead="What the motion would be",
                )

    def goal(self, status: Status) -> Motion | None:  # noqa: ARG002 - as of every goal
        """Return the chosen point, or that of the next step of the chosen sequence."""
        listed, stepper = self.selection.listed, self.sequence.stepper
        point, line, speed = listed.point, self.motion.line, self.motion.speed
        step = stepper.next if stepper is not None and not self.sequence.busy else None
        if step is not None and step.point:
            point = listed.taught.points[step.point]
            line, speed = step.how == "line", step.speed
        if point is None:
            return None
        return (LineMove if line else JointMove)(point.joints, speed)

    def show_body(self, status: Status) -> None:
        """Show the list, what is chosen, and what the motion to it would be."""
        self.selection.reread()
        self.confirmation.act_if_due()
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        keys, arm = self.desk.keys, self.desk.arm.model.arm
        listed = self.selection.listed
        rows = point_text.list_rows(listed, arm)
        self.query_one(ChoiceList).show_rows(
            rows or [point_text.none_yet(keys)], listed.at if rows else None
        )
        self.text("chosen").show_lines(self._chosen_lines())
        self.text("chosen").display = bool(self.text("chosen").shown)
        self.show_panel("how", self._how_text())
        ahead = move_text.short_text(fresh) if fresh is not None else ""
        self.show_panel("ahead", self.desk.spoken(ahead))
        self.show_panel("begin", self._begin_text(status, fresh is not None))

    def _chosen_lines(self) -> Iterator[Span]:
        sequence, point = self.sequence, self.selection.listed.point
        if sequence.stepper is not None:
            yield from point_text.sequence_lines(
                sequence.stepper,
                self.desk.keys,
                stepping=sequence.stepping,
                marked=self.selection.marked,
            )
        elif point is not None:
            yield point_text.point_text(point), ""

    def _how_text(self) -> str:
        if self.selection.listed.point is None:
            return ""
        motion = self.motion
        return point_text.how_text(line=motion.line, speed=motion.speed, keys=self.desk.keys)

    def _begin_text(self, status: Status, fresh: bool) -> str:
        keys = self.desk.keys
        if self.names.naming is not None:
            return point_text.naming_text(self.names.naming, keys)
        if self.sequence.busy:
            paused = "PAUSED: " * status.paused
            return f"{paused}UNDER WAY, {keys.label('points-pause')} pauses or goes on, space stops"
        if self.confirmation.effect:
            return f"AGAIN {self.confirmation.effect}"
        if self.sequence.stepper is not None and not self.planned.half_confirmed:
            return f"{keys.label('points-go')} twice carries out what is left"
        return self.planned.text(status, self.planned.preview if fresh else None)

    @property
    def idle(self) -> tuple[str, ...]:
        """Keys of sequences do nothing to a point, and those of points nothing to a sequence.

        While a name is typed, the keys are its letters.
        """
        if self.names.naming is not None:
            return tuple(row.id for row in self.desk.keys.rows if row.place == self.place)
        others = OF_SEQUENCES if self.selection.listed.sequence is None else OF_POINTS
        return tuple(f"points-{name}" for name in others)

    # -- keys ---------------------------------------------------------------------------------

    def take_typed(self, event: events.Key) -> bool:
        """Type the name that is asked for; other keys go on to the table of keys."""
        return event.character is not None and self.names.type(event.character)

    def action_choose(self, by: int) -> None:
        """Go to another row."""
        if not self.sequence.says_busy():
            self.selection.show(self.selection.listed.moved(by))
            self.desk.show()

    def _choose(self, row: int) -> None:
        """Go to the row that was clicked."""
        self.action_choose(row - self.selection.listed.at)

    def action_press_go(self) -> None:
        """Take the name, or one press of the two that move the arm."""
        if self.names.naming is not None:
            self.names.enter()
        elif self.sequence.stepper is None:
            self.planned.press()
        elif not self.desk.link.says_lost() and not self.sequence.says_busy():
            self.confirmation.press("CARRIES OUT WHAT IS LEFT", self.sequence.finish)
            self.desk.show()

    def action_pause(self) -> None:
        """Pause the arm after its next burst, or let it go on."""
        self.desk.link.switch_pause(self.place)


def _shown(listed: PointList) -> tuple[str, Point | None, StepList | None]:
    """Return what a person sees to be chosen."""
    return listed.name, listed.point, listed.sequence
