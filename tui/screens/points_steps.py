"""The keys of the points screen that change a sequence: a step is marked, taken out, moved."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from armdrive.points import Step, StepList
from tui.point_list import PointList
from tui.screens.points_teach import TeachKeys

Change = Callable[[list[Step], int], str]
"""Changes the steps at a marked one, and says in words what was done."""


class StepKeys(TeachKeys):
    """One step of the chosen sequence may be marked. None of these keys moves the arm."""

    def __init__(self) -> None:
        super().__init__()
        self._marked: int | None = None
        self._wrote: StepList | None = None

    @property
    def marked(self) -> int | None:
        """The marked step, from 0; None while none is."""
        steps = self.listed.sequence
        if self._marked is None or steps is None or not steps.steps:
            return None
        return min(self._marked, len(steps.steps) - 1)

    def _take(self, listed: PointList) -> None:
        if listed.name != self.listed.name or listed.sequence not in (
            self.listed.sequence,
            self._wrote,
        ):
            self._marked = None  # what was marked is another step by now
        super()._take(listed)

    def action_mark(self, by: int) -> None:
        """Mark the next step, or the one before; the first press marks the first or the last."""
        steps = self.listed.sequence
        if steps is None or not steps.steps:
            self.desk.say("choose a sequence that has steps")
            return
        self._unsure()
        before = self.marked
        first = 0 if by > 0 else len(steps.steps) - 1
        self._marked = first if before is None else (before + by) % len(steps.steps)
        self.desk.show()

    def action_shift(self, by: int) -> None:
        """Carry the marked step out sooner or later: it changes places with its neighbour."""
        at, steps = self.marked, self.listed.sequence
        if at is None or steps is None:
            self._mark_first()
        elif not 0 <= at + by < len(steps.steps):
            self.desk.say(f"it is the {'last' if by > 0 else 'first'} step of {self.listed.name}")
        else:
            self._change(partial(_shifted, by=by))
            if self._marked is not None:  # else somebody else had changed the sequence
                self._marked = at + by

    def action_drop(self) -> None:
        """Take the marked step out, after a second press."""
        at, steps = self.marked, self.listed.sequence
        if at is None or steps is None:
            self._mark_first()
            return
        words = f"takes step {at + 1} ({steps.steps[at]}) out of {self.listed.name}"
        self._make_sure(words, partial(self._change, _dropped))

    def _mark_first(self) -> None:
        keys = self.desk.keys
        both = f"{keys.label('points-step-next')} or {keys.label('points-step-previous')}"
        self.desk.say(f"mark a step of a sequence first: {both}")

    def _change(self, change: Change) -> None:
        """Write the sequence with its marked step changed, unless somebody else has changed it."""
        at, steps, name = self.marked, self.listed.sequence, self.listed.name
        if at is None or steps is None:
            return
        if self.busy:
            self.desk.say("the arm is under way: space stops it")
            return
        changed = list(steps.steps)
        said = change(changed, at)
        new, points = StepList(tuple(changed), steps.note), self.desk.arm.points
        self._wrote = new
        self._written(partial(points.put_sequence, name, new, instead_of=steps), f"{name}: {said}")


def _shifted(steps: list[Step], at: int, by: int) -> str:
    steps[at], steps[at + by] = steps[at + by], steps[at]
    return f"step {at + 1} is step {at + by + 1} now"


def _dropped(steps: list[Step], at: int) -> str:
    return f"step {at + 1} ({steps.pop(at)}) is gone"
