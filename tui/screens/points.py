"""The points screen: named places, and sequences over them, seen, gone to and stepped through."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.status import Status
from tui import move_words, point_words
from tui.errand import Ask
from tui.framework import PlainText
from tui.layout import bindings
from tui.screens.points_keys import PointKeys
from tui.widgets.arm_view import SpaceView


class PointsScreen(PointKeys):
    """The list and what is chosen of it, beside the arm with the ghost of where it would go."""

    place = "points"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #points-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #list, #chosen, #how, #ahead, #begin { height: auto; }
    #begin { text-style: bold; }
    #chosen { margin: 1 0 0 0; }
    """

    def compose_body(self) -> ComposeResult:
        """Lay the middle out."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="points-panel", can_focus=False):
                for name in ("list", "chosen", "how", "ahead", "begin"):
                    yield PlainText(id=name)

    def goal(self, status: Status) -> Ask | None:  # noqa: ARG002 - as every screen
        """Return the chosen point, or that of the next step of the chosen sequence."""
        point, line, speed = self.listed.point, self.line, self.speed
        step = self.stepper.next if self.stepper is not None and not self.busy else None
        if step is not None and step.point:
            point = self.listed.taught.points[step.point]
            line, speed = step.how == "line", step.speed
        return None if point is None else Ask(point=point, line=line, speed=speed)

    def show_body(self, status: Status) -> None:
        """Show the list, what is chosen, and what the motion to it would be."""
        self.reread()
        fresh = self.look_ahead(status)
        keys, arm = self.desk.keys, self.desk.arm.model.arm
        height = max(self.size.height // 4, 4)
        self.text("list").show(point_words.list_text(self.listed, arm, height, keys))
        self.text("chosen").show(self._chosen_text())
        self.text("how").show(self._how_text())
        ahead = move_words.short_text(fresh) if fresh is not None else ""
        self.text("ahead").show(self.desk.spoken(ahead))
        self.text("begin").show(self._begin_text(status, fresh is not None))

    def _chosen_text(self) -> str:
        if self.stepper is not None:
            return point_words.sequence_text(
                self.stepper, self.desk.keys, stepping=self.stepping, marked=self.marked
            )
        point = self.listed.point
        return "" if point is None else point_words.point_text(point)

    def _how_text(self) -> str:
        if self.listed.point is None:
            return ""
        return point_words.how_text(line=self.line, speed=self.speed, keys=self.desk.keys)

    def _begin_text(self, status: Status, fresh: bool) -> str:
        keys = self.desk.keys
        if self.naming is not None:
            return point_words.naming_text(self.naming, keys)
        if self.busy:
            paused = "PAUSED: " * status.paused
            return f"{paused}UNDER WAY, {keys.label('points-pause')} pauses or goes on, space stops"
        if self.sure_of:
            return f"AGAIN {self.sure_of}"
        if self.stepper is not None and not self.confirming.waiting:
            return f"{keys.label('points-go')} twice carries out what is left"
        return self.going_text(status, self.preview if fresh else None)
