"""Steps through a taught sequence, forwards and backwards, using the calls of an arm.

Each call carries out one step and waits for its end; `run` carries out the rest. A step that was
stopped stays the next one until it is asked for. The arm's own `pause` pauses a sequence too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from armdrive.arm import Arm
from armdrive.errors import BadRequest, Refused, Stopped
from armdrive.errors.arguments import made_of
from armdrive.moves import JointMove, LineMove
from armdrive.programs.teaching.steps import finger_move, last_point
from armdrive.storage.points import Point, Step, StepList

SLICE_S = 0.05
"""The longest sleep of a delay: between two sleeps a stop ends it."""


class Stepper:
    """A running sequence: `at` counts the steps done, so `steps[at]` is the next one."""

    def __init__(self, arm: Arm, steps: StepList, points: Mapping[str, Point]) -> None:
        """Stand before the first step. Raises `BadRequest` for an empty sequence."""
        made_of(StepList, "a sequence", 'arm.points.sequence("stack")')("steps", steps)
        made_of(Mapping, "points by their names", "arm.points")("points", points)
        if not steps.steps:
            raise BadRequest("the sequence has no steps")
        self._arm = arm
        self.points = points
        self.steps = steps.steps
        self.at = 0
        self.running = False
        self._halted = False
        self._under_way: Step | None = None

    @property
    def next(self) -> Step | None:
        """The step that `forward` would carry out, None at the end."""
        at = self.at  # read once: another thread may be carrying out a step
        return self.steps[at] if at < len(self.steps) else None

    @property
    def before(self) -> tuple[Step, str] | None:
        """What `backward` would do: the step that it undoes, and the point that it goes to.

        An arm that was stopped on its way to a point goes back to where it came from.
        """
        found = self._back()
        return None if found is None else (found[0], self.steps[found[1]].point)

    def _back(self) -> tuple[Step, int] | None:
        """Return the step to be undone, and the index of the step to the point before it."""
        moves, under_way = self._moves_done(), self._under_way
        ago = 2 if under_way is None else 1
        return (under_way or self.steps[moves[-1]], moves[-ago]) if len(moves) >= ago else None

    def forward(self, since: int | None = None) -> Step:
        """Carry out the next step. Raises `Refused` at the end, and what the motion raises.

        `since` is the arm's count of `stops` when this was decided on: after a later stop the step
        does not begin.
        """
        step = self.next
        if step is None:
            raise Refused("the sequence is at its end: step back, or begin again")
        self._done(step, self._arm.stops if since is None else since)
        return step

    def backward(self, since: int | None = None) -> str:
        """Go back to the point before, by the same kind of motion; return its name.

        The fingers stay as they are: a block stays gripped.
        """
        found = self._back()
        if found is None:
            raise Refused("the sequence has no earlier point")
        step, target = found
        point = self.steps[target].point
        stops = self._arm.stops if since is None else since
        self._require_no_stop(stops)
        self._go(point, step, stops)
        self.at = target + 1
        return point

    def run(self, shown: Callable[[Step], object] | None = None, since: int | None = None) -> int:
        """Carry out the remaining steps, or until `halt`; return the number of steps.

        `shown` is called with each step before it begins. A stop at any time, also between two
        steps, ends the sequence with `Stopped`.
        """
        stops, began = self._arm.stops if since is None else since, self.at
        self._halted, self.running = False, True
        try:
            while (step := self.next) is not None and not self._halted:
                if shown is not None:
                    shown(step)
                self._done(step, stops)
        finally:
            self.running = False
        return self.at - began

    def halt(self) -> None:
        """End `run` after the present step. May be called from any thread."""
        self._halted = True

    def rewind(self) -> None:
        """Go back to before the first step. Moves nothing."""
        self.at, self._under_way = 0, None

    # -- one step -----------------------------------------------------------------------------

    def _done(self, step: Step, stops: int) -> None:
        self._require_no_stop(stops)
        if step.point:
            self._go(step.point, step, stops)
        elif step.gripper is not None:
            at = self.points.get(last_point(self.steps[: self.at]))
            self._arm.start(finger_move(step, at), stops=stops).wait()
        else:
            self._wait(step.wait_s or 0.0, stops)
        self.at += 1

    def _go(self, point: str, step: Step, stops: int) -> None:
        kind = LineMove if step.how == "line" else JointMove
        handle = self._arm.start(kind(self.points[point].joints, step.speed), stops=stops)
        self._under_way = step if self._moves_done() else None
        handle.wait()
        self._under_way = None
        self._require_no_stop(stops)

    def _wait(self, time_s: float, stops: int) -> None:
        left_s = time_s
        while left_s > 0.0:
            self._arm.sleep(min(left_s, SLICE_S))
            left_s -= SLICE_S
            self._require_no_stop(stops)

    def _require_no_stop(self, stops: int) -> None:
        if self._arm.stops != stops:
            raise Stopped(f"the sequence was stopped at step {self.at + 1}")

    def _moves_done(self) -> list[int]:
        return [index for index, step in enumerate(self.steps[: self.at]) if step.point]
