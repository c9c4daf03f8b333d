"""The keys of the points screen that change its file: points and names, and steps of sequences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from textual import events

from armdrive.errors import ArmError, BadRequest
from armdrive.programs.teaching.sequence import Stepper
from armdrive.storage.points import Point, Step, StepList
from kinematics.errors import KinematicsError
from tui.move.errand import ErrandScreen, Twice
from tui.points.list import STEPS, PointList, PointNaming
from tui.settings import SPEEDS

Change = Callable[[list[Step], int], str]
"""Changes the steps at a marked one, and says in words what was done."""


class PointEditor(ErrandScreen):
    """The list, the names and one marked step. None of its keys moves the arm.

    Nothing is written over what somebody else has changed.
    """

    def __init__(self) -> None:
        super().__init__()
        self.listed = PointList()
        self.line = False
        self.speed = 0.5
        self.naming: PointNaming | None = None
        self.stepper: Stepper | None = None
        self.stepping = False
        self.busy = False
        self.sure = Twice(self.desk.clock)
        self.sure_of = ""
        """What a second press of the same key would do, in words."""
        self._deed: Callable[[], None] = _nothing
        self._last_sequence = "sequence"
        self._stamp: object = ()
        self._marked: int | None = None
        self._wrote: StepList | None = None

    def disarm(self, reason: str) -> None:
        """Let nothing go on that is not under way; a sequence ends behind its step."""
        super().disarm(reason)
        self.naming, self.stepping = None, False
        self._unsure()
        if self.stepper is not None:
            self.stepper.halt()

    # -- the file -----------------------------------------------------------------------------

    def reread(self) -> None:
        """Take up what stands in the file, when it has changed."""
        points = self.desk.arm.points
        if (stamp := points.stamp) == self._stamp:
            return self._decide()
        self._stamp = stamp
        try:
            self._take(self.listed.with_taught(points.read()))
        except ArmError as error:
            self.desk.message = str(error)
        return self._decide()

    def _take(self, listed: PointList) -> None:
        """Show another row, or the same one of another file; a sequence begins anew then."""
        known = (self.listed.sequence, self._wrote)
        if listed.name != self.listed.name or listed.sequence not in known:
            self._marked = None  # what was marked is another step by now
        before, self.listed = self.listed, listed
        if _shown(before) != _shown(listed):  # what was asked for was meant of what was seen
            self.confirming.forget()
            self._unsure()
        steps = listed.sequence
        same = (
            self.stepper is not None
            and steps is not None
            and (self.stepper.steps == steps.steps and before.name == listed.name)
        )
        if same and self.stepper is not None:
            self.stepper.points = listed.taught.points
        elif not self.busy:
            good = steps is not None and bool(steps.steps)
            self.stepper = (
                Stepper(self.desk.arm, steps, listed.taught.points)
                if steps is not None and good
                else None
            )
            self.stepping = False

    def _written(self, change: Callable[[], object], said: str) -> None:
        """Change the file, and say so, or why not."""
        try:
            change()
        except (ArmError, KinematicsError) as error:
            self.desk.say(str(error))
        else:
            self.desk.say(said)

    # -- what takes two presses ---------------------------------------------------------------

    def _unsure(self) -> None:
        self.sure.forget()
        self.sure_of = ""

    def _make_sure(self, words: str, deed: Callable[[], None]) -> None:
        if self.sure_of != words:
            self._unsure()
        self.sure_of, self._deed = words, deed
        self.sure.press()
        self.desk.show()

    def _decide(self) -> None:
        """Do what was asked for twice."""
        if self.sure.due():
            self._unsure()
            self._deed()
        elif not self.sure.pressed:
            self.sure_of = ""

    def action_delete(self) -> None:
        """Take the chosen row out of the file."""
        listed, points = self.listed, self.desk.arm.points
        name, point, steps = listed.name, listed.point, listed.sequence
        if point is not None:
            change: Callable[[], None] = partial(points.remove, name, instead_of=point)
        elif steps is not None:
            change = partial(points.remove_sequence, name, instead_of=steps)
        else:
            return
        deed = partial(self._written, change, f"{name} is deleted")
        self._make_sure(f"deletes {name}", deed)

    def action_again(self) -> None:
        """Move the chosen point to where the arm stands."""
        name, point = self.listed.name, self.listed.point
        if point is None:
            self.desk.say("choose a point to teach again")
            return
        change = partial(self.desk.arm.points.teach, name, again=True)
        deed = partial(self._written, change, f"{name} is here now")
        self._make_sure(f"moves {name} to where the arm stands", deed)

    # -- names --------------------------------------------------------------------------------

    def action_teach(self) -> None:
        """Ask for the name of the place where the arm stands."""
        self._ask_name(PointNaming("teach", self.listed.free_name(), offered=True))

    def action_rename(self) -> None:
        """Ask for another name of the chosen point."""
        if self.listed.point is None:
            self.desk.say("choose a point to rename; sequences are renamed in the file")
        else:
            self._ask_name(PointNaming("rename", self.listed.name))

    def action_append(self) -> None:
        """Ask for the sequence that the chosen point is put at the end of."""
        if self.listed.point is None:
            self.desk.say("choose a point to put into a sequence")
        else:
            self._ask_name(PointNaming("append", self._last_sequence, offered=True))

    def _ask_name(self, naming: PointNaming) -> None:
        self.disarm("a name is asked for")
        self.naming = naming
        self.desk.show()

    def on_key(self, event: events.Key) -> None:
        """Type the name that is asked for; other keys go on to the table of keys."""
        letter = event.character
        if self.naming is not None and letter is not None and self.naming.takes(letter):
            event.stop()
            event.prevent_default()
            self.naming = self.naming.typed(letter)
            self.desk.show()

    def action_shorten(self) -> None:
        """Take away the last letter of the name, or the last step of the sequence."""
        name, steps = self.listed.name, self.listed.sequence
        if self.naming is not None:
            self.naming = self.naming.erased()
            self.desk.show()
        elif steps is None or not steps.steps:
            self.desk.say("choose a sequence that has steps")
        else:
            shorter = StepList(steps.steps[:-1], steps.note)
            points = self.desk.arm.points
            change = partial(points.put_sequence, name, shorter, instead_of=steps)
            self._written(change, f"{name} ends a step sooner: {steps.steps[-1]} is gone")

    def _named(self, naming: PointNaming) -> None:
        """Do what the name was asked for."""
        if naming.purpose in STEPS:
            self._step_named(naming)
            return
        points, name = self.desk.arm.points, naming.text
        self.naming = None
        if naming.purpose == "teach":
            self._written(partial(points.teach, name), f"{name} is here")
            self.listed = self.listed.choosing(name)
        elif naming.purpose == "rename":
            self._written(partial(points.rename, self.listed.name, name), f"it is {name} now")
            self.listed = self.listed.choosing(name)
        else:
            self._last_sequence = name
            before = self.listed.taught.sequences.get(name)
            step = Step(self.listed.name, "line" if self.line else "joint", self.speed)
            made = StepList(
                (*(before.steps if before else ()), step), before.note if before else ""
            )
            self._written(
                partial(points.put_sequence, name, made, instead_of=before),
                f"step {len(made.steps)} of {name}: {step}",
            )

    # -- the marked step ----------------------------------------------------------------------

    @property
    def marked(self) -> int | None:
        """The marked step, from 0; None while none is."""
        steps = self.listed.sequence
        if self._marked is None or steps is None or not steps.steps:
            return None
        return min(self._marked, len(steps.steps) - 1)

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
        self._ask_step(PointNaming("gripper", "open", offered=True))

    def action_add_wait(self) -> None:
        """Ask how long a further step shall wait."""
        self._ask_step(PointNaming("wait", "1", offered=True))

    def _ask_step(self, naming: PointNaming) -> None:
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

    def _step_named(self, naming: PointNaming) -> None:
        """Put the step that was typed into the chosen sequence."""
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


def _shown(listed: PointList) -> tuple[str, Point | None, StepList | None]:
    """Return what a person sees to be chosen."""
    return listed.name, listed.point, listed.sequence


def _nothing() -> None:
    """Do nothing."""


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


def _changing(step: Step) -> PointNaming:
    """Return what is typed to have another step in the place of this one, with what it says."""
    if step.point:
        return PointNaming("to", step.point, changes=True)
    if step.wait_s is not None:
        return PointNaming("wait", f"{step.wait_s:g}", offered=True, changes=True)
    said = step.gripper if isinstance(step.gripper, str) else f"{step.gripper:g}"
    return PointNaming("gripper", said, offered=True, changes=True)


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
