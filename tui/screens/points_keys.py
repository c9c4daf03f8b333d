"""The keys of the points screen that move the arm: going, running, stepping, pausing."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Protocol

from tui.goal_form import SPEEDS, neighbour
from tui.screens.points_steps import StepKeys, other_speed, other_way

if TYPE_CHECKING:
    from armdrive.programs.teaching.sequence import Stepper
    from armdrive.status import Status

OF_POINTS = ("again", "rename", "edit", "line", "slower", "faster", "append")
OF_SEQUENCES = ("step-next", "grip", "wait", "stepping", "forward", "backward", "rewind")
"""Rows of the table of keys that are about the one alone, or mostly."""

STEP_QUIET_S = 0.7
"""A step key counts after so long without one: a key that is held repeats sooner."""


class Deed(Protocol):
    """What a stepper can do, unless a stop was asked for since it was decided on."""

    def __call__(self, *, since: int) -> object:
        """Do it."""


class PointKeys(StepKeys):
    """What the keys do. One step or run at a time; a stop that comes first lets it not begin."""

    _step_s = -STEP_QUIET_S

    @property
    def idle(self) -> tuple[str, ...]:
        """Keys of sequences do nothing to a point, and those of points nothing to a sequence.

        While a name is typed, the keys are its letters.
        """
        if self.naming is not None:
            return tuple(row.id for row in self.desk.keys.rows if row.place == self.place)
        others = OF_SEQUENCES if self.listed.sequence is None else OF_POINTS
        return tuple(f"points-{name}" for name in others)

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
