"""A sequence that is run or stepped through: one step at a time, and none after a stop."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from armdrive.errors import BadRequest
from armdrive.programs.teaching.sequence import Stepper
from tui.desk import Desk
from tui.keys.presses import STEP_QUIET_S, SinglePress
from tui.points.list import PointList

StepCall = Callable[..., object]
"""Carries out a step; does nothing if a stop was asked for after the count `since`."""


class SequenceRun:
    """Carries out the chosen sequence. A stop that comes first lets a step not begin."""

    def __init__(self, desk: Desk) -> None:
        self.stepper: Stepper | None = None
        """Goes through the chosen sequence; None where a point or nothing is chosen."""
        self.stepping = False
        """Whether the step keys move the arm."""
        self.busy = False
        """Whether the arm is under way."""
        self._desk = desk
        self._name = ""
        self._press = SinglePress(desk.clock, STEP_QUIET_S)

    def follow(self, listed: PointList, *, same_row: bool) -> None:
        """Take what is chosen now; a sequence starts over unless its steps are the same."""
        self._name = listed.name
        stepper, steps = self.stepper, listed.sequence
        if stepper is not None and steps is not None and same_row and stepper.steps == steps.steps:
            stepper.points = listed.taught.points
        elif not self.busy:
            none = steps is None or not steps.steps
            points = listed.taught.points
            self.stepper = None if none or steps is None else Stepper(self._desk.arm, steps, points)
            self.stepping = False

    def disarm(self) -> None:
        """Let no step key move the arm; a run ends after the step that is under way."""
        self.stepping = False
        if self.stepper is not None:
            self.stepper.halt()

    def require_standstill(self) -> None:
        """Raise `BadRequest` while the arm is under way."""
        if self.busy:
            raise BadRequest("the arm is under way: space stops it")

    def switch_stepping(self) -> None:
        """Let the step keys move the arm, or no longer."""
        if self.stepper is None:
            raise BadRequest("choose a sequence to step through")
        self.stepping = not self.stepping

    def forward(self) -> None:
        """Carry out the next step."""
        if self.stepper is not None and self._may_step():
            self._begin(self.stepper.forward)

    def backward(self) -> None:
        """Go back to the point before."""
        if self.stepper is not None and self._may_step():
            self._begin(self.stepper.backward)

    def finish(self) -> None:
        """Carry out all steps that are left."""
        if self.stepper is not None:
            self._begin(self.stepper.run)

    def rewind(self) -> None:
        """Start the sequence over. Moves nothing."""
        if self.stepper is not None:
            self.require_standstill()
            self.stepper.rewind()

    def _may_step(self) -> bool:
        """Return whether a step key counts: not as the repeat of a held key.

        Raises `BadRequest` where the step keys do not move the arm.
        """
        counts = self._press.counts()
        self._desk.link.require_motion()
        self.require_standstill()
        if not self.stepping:
            key = self._desk.keys.label("points-stepping")
            raise BadRequest(f"{key} lets this key move the arm")
        return counts

    def _begin(self, step: StepCall) -> None:
        self.busy = True
        if self.stepper is not None:
            self._desk.arm.program = partial(_program, self._name, self.stepper)
        self._desk.calls.make(partial(self._carry_out, step, self._desk.arm.stops))

    def _carry_out(self, step: StepCall, stops: int) -> str:
        try:
            step(since=stops)  # a stop may come while this is on its way to the arm
        finally:
            self.busy = False
            self._desk.arm.program = None
        following = None if self.stepper is None else self.stepper.next
        return "the sequence is at its end" if following is None else f"next: {following}"


def _program(name: str, stepper: Stepper) -> dict[str, object]:
    """Return a sequence under way as it is reported to other programs."""
    step, steps = stepper.next or stepper.steps[-1], len(stepper.steps)
    line = min(stepper.at + 1, steps)
    return {"file": name, "line": line, "steps": steps, "text": str(step), "act": "step",
            "loop": 1, "loops": 1, "percent": None, "left_s": None}  # fmt: skip
