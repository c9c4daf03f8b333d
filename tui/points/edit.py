"""The keys of the points screen that change its file: points and names, and steps of sequences.

None of them moves the arm, and none overwrites a change that another program has made.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from armdrive.errors import ArmError, BadRequest
from armdrive.storage.points import Step, StepList
from kinematics.errors import KinematicsError
from tui.keys.presses import Confirmation
from tui.points.list import NameEntry, PointNaming, PointSelection
from tui.screens import ScreenHost
from tui.settings import SPEEDS, neighbour

Change = Callable[[list[Step], int], str]
"""Changes the steps at a marked one, and says in words what was done."""


def write(desk: ScreenHost, change: Callable[[], object], message: str) -> None:
    """Change the file, and say so, or why not."""
    try:
        change()
    except (ArmError, KinematicsError) as error:
        desk.say(str(error))
    else:
        desk.say(message)


class StepEdits:
    """Changes of the chosen sequence, most of them at its marked step."""

    def __init__(
        self,
        desk: ScreenHost,
        selection: PointSelection,
        names: NameEntry,
        confirmation: Confirmation,
        says_busy: Callable[[], bool],
    ) -> None:
        """`says_busy` returns whether the arm is under way, and then says so."""
        self._desk = desk
        self._selection = selection
        self._names = names
        self._confirmation = confirmation
        self._says_busy = says_busy

    @property
    def _steps(self) -> StepList | None:
        return self._selection.listed.sequence

    def mark(self, by: int) -> None:
        """Mark the next step, or the one before; the first press marks the first or the last."""
        steps = self._steps
        if steps is None or not steps.steps:
            self._desk.say("choose a sequence that has steps")
            return
        self._confirmation.forget()
        before = self._selection.marked
        first = 0 if by > 0 else len(steps.steps) - 1
        self._selection.mark(first if before is None else (before + by) % len(steps.steps))
        self._desk.show()

    def shift(self, by: int) -> None:
        """Carry the marked step out sooner or later: it changes places with its neighbour."""
        at, steps = self._selection.marked, self._steps
        if at is None or steps is None:
            self._ask_for_mark()
        elif not 0 <= at + by < len(steps.steps):
            end = "last" if by > 0 else "first"
            self._desk.say(f"it is the {end} step of {self._selection.listed.name}")
        else:
            self._change(partial(_shifted, by=by))
            if self._selection.marked is not None:  # else another program had changed the sequence
                self._selection.mark(at + by)

    def drop(self) -> None:
        """Take the marked step out, after a second press."""
        at, steps = self._selection.marked, self._steps
        if at is None or steps is None:
            self._ask_for_mark()
            return
        effect = f"takes step {at + 1} ({steps.steps[at]}) out of {self._selection.listed.name}"
        self._confirmation.press(effect, partial(self._change, _dropped))
        self._desk.show()

    def shorten(self) -> None:
        """Take away the last step of the sequence; of a name being typed, the last letter."""
        name, steps = self._selection.listed.name, self._steps
        if self._names.naming is not None:
            self._names.erase()
        elif steps is None or not steps.steps:
            self._desk.say("choose a sequence that has steps")
        else:
            shorter = StepList(steps.steps[:-1], steps.note)
            put = self._desk.arm.points.put_sequence
            message = f"{name} ends a step sooner: {steps.steps[-1]} is gone"
            write(self._desk, partial(put, name, shorter, instead_of=steps), message)

    def add_grip(self) -> None:
        """Ask what the fingers shall do in a further step."""
        self._ask(PointNaming("gripper", "open", offered=True))

    def add_wait(self) -> None:
        """Ask how long a further step shall wait."""
        self._ask(PointNaming("wait", "1", offered=True))

    def change(self) -> None:
        """Ask what the marked step shall be instead."""
        at, steps = self._selection.marked, self._steps
        if at is None or steps is None:
            self._ask_for_mark()
        else:
            self._ask(_changing(steps.steps[at]))

    def retime(self, change: Callable[[Step], Step]) -> bool:
        """Change the way or the speed of the marked step; return whether one is marked."""
        at, steps = self._selection.marked, self._steps
        if at is None or steps is None:
            return False
        try:
            self._change(partial(_changed, new=change(steps.steps[at])))
        except BadRequest as error:
            self._desk.say(str(error))
        return True

    def _ask(self, naming: PointNaming) -> None:
        if self._steps is None:
            self._desk.say("choose a sequence to put it into; a point begins one")
        else:
            marked = self._selection.marked
            self._names.ask(naming, self._take)
            self._selection.mark(marked)

    def _take(self, naming: PointNaming) -> None:
        """Put the step that was typed into the chosen sequence."""
        at, steps = self._selection.marked, self._steps
        if steps is None or (naming.changes and at is None):
            self._names.clear()
            self._desk.say("another program has changed the sequence: look at it, and mark a step")
            return
        before = steps.steps[at] if naming.changes and at is not None else None
        try:
            opening_mm = self._desk.link.status.gripper_mm
            step = naming.step(opening_mm, before.speed if before else 1.0)
            if before is not None and step.point:
                step = replace(step, how=before.how)
        except BadRequest as error:
            self._desk.say(str(error))  # what was typed can still be mended
            return
        self._names.clear()
        if before is not None:
            self._change(partial(_changed, new=step))
        else:
            self._add(step, len(steps.steps) if at is None else at + 1)

    def _add(self, step: Step, at: int) -> None:
        marked = self._selection.marked is not None
        if self._write(partial(_added, new=step), at) and marked:
            self._selection.mark(at)

    def _ask_for_mark(self) -> None:
        keys = self._desk.keys
        both = f"{keys.label('points-step-next')} or {keys.label('points-step-previous')}"
        self._desk.say(f"mark a step of a sequence first: {both}")

    def _change(self, change: Change) -> None:
        """Write the sequence with its marked step changed, unless a program has changed it."""
        if (at := self._selection.marked) is not None:
            self._write(change, at)

    def _write(self, change: Change, at: int) -> bool:
        """Write the sequence changed at a place; return whether that could be tried."""
        steps, name = self._steps, self._selection.listed.name
        if steps is None or self._says_busy():
            return False
        changed = list(steps.steps)
        message = change(changed, at)
        new = StepList(tuple(changed), steps.note)
        self._selection.written = new
        put = self._desk.arm.points.put_sequence
        write(self._desk, partial(put, name, new, instead_of=steps), f"{name}: {message}")
        return True


class PointMotion:
    """How points are gone to: in a line or by a joint motion, and how fast."""

    def __init__(self, desk: ScreenHost, steps: StepEdits, forget: Callable[[], None]) -> None:
        """`forget` takes back a first press, which was meant for another motion."""
        self.line = False
        self.speed = 0.5
        self._desk = desk
        self._steps = steps
        self._forget = forget

    def switch_line(self) -> None:
        """Switch between a straight line and a joint motion, also of a marked step."""
        self._forget()
        if not self._steps.retime(_other_way):
            self.line = not self.line
            self._desk.show()

    def change_speed(self, by: int) -> None:
        """Go faster or more slowly, also in a marked step."""
        self._forget()
        if not self._steps.retime(partial(_other_speed, by=by)):
            self.speed = neighbour(SPEEDS, self.speed, by)
            self._desk.show()


class PointEdits:
    """Changes of the chosen point, and of the list."""

    def __init__(
        self,
        desk: ScreenHost,
        selection: PointSelection,
        names: NameEntry,
        confirmation: Confirmation,
        motion: PointMotion,
    ) -> None:
        self._desk = desk
        self._selection = selection
        self._names = names
        self._confirmation = confirmation
        self._motion = motion
        self._last_sequence = "sequence"

    def delete(self) -> None:
        """Take the chosen row out of the file, after a second press."""
        listed, points = self._selection.listed, self._desk.arm.points
        name, point, steps = listed.name, listed.point, listed.sequence
        if point is not None:
            change: Callable[[], None] = partial(points.remove, name, instead_of=point)
        elif steps is not None:
            change = partial(points.remove_sequence, name, instead_of=steps)
        else:
            return
        self._confirm(f"deletes {name}", change, f"{name} is deleted")

    def teach_again(self) -> None:
        """Move the chosen point to where the arm stands, after a second press."""
        name, point = self._selection.listed.name, self._selection.listed.point
        if point is None:
            self._desk.say("choose a point to teach again")
            return
        change = partial(self._desk.arm.points.teach, name, again=True)
        self._confirm(f"moves {name} to where the arm stands", change, f"{name} is here now")

    def _confirm(self, effect: str, change: Callable[[], object], message: str) -> None:
        self._confirmation.press(effect, partial(write, self._desk, change, message))
        self._desk.show()

    def teach(self) -> None:
        """Ask for the name of the place where the arm stands."""
        naming = PointNaming("teach", self._selection.listed.free_name(), offered=True)
        self._names.ask(naming, self._teach)

    def _teach(self, naming: PointNaming) -> None:
        self._names.clear()
        name = naming.text
        write(self._desk, partial(self._desk.arm.points.teach, name), f"{name} is here")
        self._selection.choose_name(name)

    def rename(self) -> None:
        """Ask for another name of the chosen point."""
        if self._selection.listed.point is None:
            self._desk.say("choose a point to rename; sequences are renamed in the file")
        else:
            self._names.ask(PointNaming("rename", self._selection.listed.name), self._rename)

    def _rename(self, naming: PointNaming) -> None:
        self._names.clear()
        before, name = self._selection.listed.name, naming.text
        change = partial(self._desk.arm.points.rename, before, name)
        write(self._desk, change, f"it is {name} now")
        self._selection.choose_name(name)

    def append(self) -> None:
        """Ask for the sequence that the chosen point is put at the end of."""
        if self._selection.listed.point is None:
            self._desk.say("choose a point to put into a sequence")
        else:
            naming = PointNaming("append", self._last_sequence, offered=True)
            self._names.ask(naming, self._append)

    def _append(self, naming: PointNaming) -> None:
        self._names.clear()
        self._last_sequence = name = naming.text
        listed, motion = self._selection.listed, self._motion
        before = listed.taught.sequences.get(name)
        step = Step(listed.name, "line" if motion.line else "joint", motion.speed)
        steps, note = ((), "") if before is None else (before.steps, before.note)
        made = StepList((*steps, step), note)
        put = partial(self._desk.arm.points.put_sequence, name, made, instead_of=before)
        write(self._desk, put, f"step {len(made.steps)} of {name}: {step}")

    def move_there(self) -> None:
        """Ask for the chosen point on the move screen, to change it there."""
        point = self._selection.listed.point
        if point is None:
            mark = self._desk.keys.label("points-step-next")
            self._desk.say(f"choose a point to change; {mark} marks a step of a sequence")
            return
        self._desk.goal = point.joints
        self._desk.screens.go_to("move")


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
    typed = step.gripper if isinstance(step.gripper, str) else f"{step.gripper:g}"
    return PointNaming("gripper", typed, offered=True, changes=True)


def _other_way(step: Step) -> Step:
    """Return the step with the other way to its point; raises `BadRequest` where it has none."""
    return replace(step, how="joint" if step.how == "line" else "line")


def _other_speed(step: Step, by: int) -> Step:
    """Return the step at the next speed of the table, faster or slower; the ends are the ends."""
    if step.wait_s is not None:
        raise BadRequest("a wait has no speed")
    others = [each for each in SPEEDS if (each - step.speed) * by > 0.0]
    nearest = (min if by > 0 else max)(others, default=step.speed)
    return replace(step, speed=nearest)
