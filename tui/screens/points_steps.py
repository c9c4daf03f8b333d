"""The keys of the points screen that change a sequence: steps are added, marked, changed, moved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from armdrive.errors import BadRequest
from armdrive.storage.points import Step, StepList
from tui.goal_form import SPEEDS
from tui.point_list import STEPS, Naming, PointList
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

    # -- what a step is -----------------------------------------------------------------------

    def action_add_grip(self) -> None:
        """Ask what the fingers shall do in a further step."""
        self._ask_step(Naming("gripper", "open", offered=True))

    def action_add_wait(self) -> None:
        """Ask how long a further step shall wait."""
        self._ask_step(Naming("wait", "1", offered=True))

    def _ask_step(self, naming: Naming) -> None:
        if self.listed.sequence is None:
            self.desk.say("choose a sequence to put it into; a point begins one")
        else:
            marked = self.marked
            self._ask_name(naming)
            self._marked = marked

    def action_change(self) -> None:
        """Ask what the marked step shall be instead."""
        at, steps = self.marked, self.listed.sequence
        if at is None or steps is None:
            self._mark_first()
        else:
            self._ask_step(_changing(steps.steps[at]))

    def _named(self, naming: Naming) -> None:
        if naming.purpose not in STEPS:
            super()._named(naming)
            return
        at, steps = self.marked, self.listed.sequence
        if steps is None or (naming.changes and at is None):
            self.naming = None
            self.desk.say("somebody else has changed the sequence: look at it, and mark a step")
            return
        before = steps.steps[at] if naming.changes and at is not None else None
        try:
            step = naming.step(self.desk.status.gripper_mm, before.speed if before else 1.0)
            if before is not None and step.point:
                step = replace(step, how=before.how)
        except BadRequest as error:
            self.desk.say(str(error))  # what was typed can still be mended
            return
        self.naming = None
        if before is not None:
            self._change(partial(_changed, new=step))
        else:
            self._add(step, len(steps.steps) if at is None else at + 1)

    def _add(self, step: Step, at: int) -> None:
        marked = self.marked is not None
        if self._write(partial(_added, new=step), at) and marked:
            self._marked = at

    def retime(self, change: Callable[[Step], Step]) -> bool:
        """Change the way or the speed of the marked step; tell whether one is marked."""
        at, steps = self.marked, self.listed.sequence
        if at is None or steps is None:
            return False
        try:
            self._change(partial(_changed, new=change(steps.steps[at])))
        except BadRequest as error:
            self.desk.say(str(error))
        return True

    # -- writing ------------------------------------------------------------------------------

    def _mark_first(self) -> None:
        keys = self.desk.keys
        both = f"{keys.label('points-step-next')} or {keys.label('points-step-previous')}"
        self.desk.say(f"mark a step of a sequence first: {both}")

    def _change(self, change: Change) -> None:
        """Write the sequence with its marked step changed, unless somebody else has changed it."""
        if (at := self.marked) is not None:
            self._write(change, at)

    def _write(self, change: Change, at: int) -> bool:
        """Write the sequence changed at a place; tell whether it could be tried."""
        steps, name = self.listed.sequence, self.listed.name
        if steps is None:
            return False
        if self.busy:
            self.desk.say("the arm is under way: space stops it")
            return False
        changed = list(steps.steps)
        said = change(changed, at)
        new, points = StepList(tuple(changed), steps.note), self.desk.arm.points
        self._wrote = new
        self._written(partial(points.put_sequence, name, new, instead_of=steps), f"{name}: {said}")
        return True


def _shifted(steps: list[Step], at: int, by: int) -> str:
    steps[at], steps[at + by] = steps[at + by], steps[at]
    return f"step {at + 1} is step {at + by + 1} now"


def _dropped(steps: list[Step], at: int) -> str:
    return f"step {at + 1} ({steps.pop(at)}) is gone"


def _added(steps: list[Step], at: int, new: Step) -> str:
    steps.insert(at, new)
    return f"step {at + 1} is {new}"


def _changed(steps: list[Step], at: int, new: Step) -> str:
    steps[at] = new
    return f"step {at + 1} is {new} now"


def _changing(step: Step) -> Naming:
    """Return what is typed to have another step in the place of this one, with what it says."""
    if step.point:
        return Naming("to", step.point, changes=True)
    if step.wait_s is not None:
        return Naming("wait", f"{step.wait_s:g}", offered=True, changes=True)
    said = step.gripper if isinstance(step.gripper, str) else f"{step.gripper:g}"
    return Naming("gripper", said, offered=True, changes=True)


def other_way(step: Step) -> Step:
    """Return the step with the other way to its point; raises `BadRequest` where it has none."""
    return replace(step, how="joint" if step.how == "line" else "line")


def other_speed(step: Step, by: int) -> Step:
    """Return the step at the next speed of the table, faster or slower; the ends are the ends."""
    if step.wait_s is not None:
        raise BadRequest("a wait has no speed")
    others = [each for each in SPEEDS if (each - step.speed) * by > 0.0]
    nearest = (min if by > 0 else max)(others, default=step.speed)
    return replace(step, speed=nearest)
