"""The points screen: named places, and sequences over them, seen, gone to and stepped through."""

from __future__ import annotations

from functools import partial
from typing import ClassVar, Protocol

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.moves import JointMove, LineMove, Motion
from armdrive.programs.teaching.sequence import Stepper
from armdrive.status import Status
from tui.arm_view import SpaceView
from tui.framework import PlainText
from tui.keys.keyboard import bindings
from tui.move import words as move_words
from tui.move.form import neighbour
from tui.points import list as point_words
from tui.points.edit import PointEditor, other_speed, other_way
from tui.settings import SPEEDS

OF_POINTS = ("again", "rename", "edit", "line", "slower", "faster", "append")
OF_SEQUENCES = ("step-next", "grip", "wait", "stepping", "forward", "backward", "rewind")
"""Rows of the table of keys that are about the one alone, or mostly."""

STEP_QUIET_S = 0.7
"""A step key counts after so long without one: a key that is held repeats sooner."""


class Deed(Protocol):
    """What a stepper can do, unless a stop was asked for since it was decided on."""

    def __call__(self, *, since: int) -> object:
        """Do it."""


class PointsScreen(PointEditor):
    """The list and what is chosen of it, beside the arm with the ghost of where it would go.

    One step or run at a time; a stop that comes first lets it not begin.
    """

    place = "points"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #points-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #list, #chosen, #how, #ahead, #begin { height: auto; }
    #begin { text-style: bold; }
    #chosen { margin: 1 0 0 0; }
    """
    _step_s = -STEP_QUIET_S

    def compose_body(self) -> ComposeResult:
        """Lay the middle out."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="points-panel", can_focus=False):
                for name in ("list", "chosen", "how", "ahead", "begin"):
                    yield PlainText(id=name)

    def goal(self, status: Status) -> Motion | None:  # noqa: ARG002 - as every screen
        """Return the chosen point, or that of the next step of the chosen sequence."""
        point, line, speed = self.listed.point, self.line, self.speed
        step = self.stepper.next if self.stepper is not None and not self.busy else None
        if step is not None and step.point:
            point = self.listed.taught.points[step.point]
            line, speed = step.how == "line", step.speed
        if point is None:
            return None
        return (LineMove if line else JointMove)(point.joints, speed)

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

    @property
    def idle(self) -> tuple[str, ...]:
        """Keys of sequences do nothing to a point, and those of points nothing to a sequence.

        While a name is typed, the keys are its letters.
        """
        if self.naming is not None:
            return tuple(row.id for row in self.desk.keys.rows if row.place == self.place)
        others = OF_SEQUENCES if self.listed.sequence is None else OF_POINTS
        return tuple(f"points-{name}" for name in others)

    # -- the keys that move the arm -----------------------------------------------------------

    def action_choose(self, by: int) -> None:
        """Go to another row."""
        if self.busy:
            self.desk.say("the arm is under way: space stops it")
            return
        self._take(self.listed.moved(by))
        self.desk.show()

    # -- going --------------------------------------------------------------------------------

    def action_press_go(self) -> None:
        """Take the name, or one press of the two that move the arm."""
        if self.naming is not None:
            self._named(self.naming)
        elif self.stepper is None:
            super().action_press_go()
        elif not self.desk.nobody_there() and not self._is_busy():
            self._make_sure("CARRIES OUT WHAT IS LEFT", self._run)

    def _run(self) -> None:
        if self.stepper is not None:
            self._begin(self.stepper.run)

    def action_stepping(self) -> None:
        """Let the step keys move the arm, or no longer."""
        if self.stepper is None:
            self.desk.say("choose a sequence to step through")
            return
        self.stepping = not self.stepping
        self.desk.show()

    def action_forward(self) -> None:
        """Carry out the next step."""
        if self.stepper is not None and self._may_step():
            self._begin(self.stepper.forward)

    def action_backward(self) -> None:
        """Go back to the point before."""
        if self.stepper is not None and self._may_step():
            self._begin(self.stepper.backward)

    def action_rewind(self) -> None:
        """Begin the sequence anew. Moves nothing."""
        if self.stepper is not None and not self._is_busy():
            self.stepper.rewind()
            self.desk.show()

    def _may_step(self) -> bool:
        """Tell whether a step key counts: while stepping, and not as the repeat of a held key."""
        now_s = self.desk.clock()
        quiet_s, self._step_s = now_s - self._step_s, now_s
        if self.desk.nobody_there() or self._is_busy():
            return False
        if not self.stepping:
            self.desk.say(f"{self.desk.keys.label('points-stepping')} lets this key move the arm")
            return False
        return quiet_s >= STEP_QUIET_S

    def _is_busy(self) -> bool:
        if self.busy:
            self.desk.say("the arm is under way: space stops it")
        return self.busy

    def _begin(self, deed: Deed) -> None:
        self.busy = True
        self.desk.message = ""
        if self.stepper is not None:
            self.desk.arm.program = partial(_program, self.listed.name, self.stepper)
        self.desk.call(partial(self._done, deed, self.desk.arm.stops), self._said)

    def _done(self, deed: Deed, stops: int) -> None:
        try:
            deed(since=stops)  # a stop may come while this is on its way to the arm
        finally:
            self.busy = False
            self.desk.arm.program = None

    def _said(self, status: Status) -> str:  # noqa: ARG002 - as the desk calls it
        stepper = self.stepper
        if stepper is None:
            return ""
        return "the sequence is at its end" if stepper.next is None else f"next: {stepper.next}"

    def action_pause(self) -> None:
        """Hold the arm up behind its next burst, or let it go on."""
        self.desk.pause_or_go_on()

    # -- how ----------------------------------------------------------------------------------

    def action_line(self) -> None:
        """Switch between a straight line and a joint motion."""
        self.confirming.forget()
        if self.retime(other_way):
            return
        self.line = not self.line
        self.desk.show()

    def action_speed(self, by: int) -> None:
        """Go faster or more slowly."""
        self.confirming.forget()
        if self.retime(partial(other_speed, by=by)):
            return
        self.speed = neighbour(SPEEDS, self.speed, by)
        self.desk.show()

    def action_edit(self) -> None:
        """Ask for the chosen point on the move screen."""
        point = self.listed.point
        if point is None:
            mark = self.desk.keys.label("points-step-next")
            self.desk.say(f"choose a point to change; {mark} marks a step of a sequence")
            return
        self.desk.goal = point.joints
        self.desk.show_screen("move")


def _program(name: str, stepper: Stepper) -> dict[str, object]:
    """Return a sequence under way as other programs are told of it."""
    step, steps = stepper.next or stepper.steps[-1], len(stepper.steps)
    line = min(stepper.at + 1, steps)
    return {"file": name, "line": line, "steps": steps, "text": str(step), "act": "step",
            "loop": 1, "loops": 1, "percent": None, "left_s": None}  # fmt: skip
