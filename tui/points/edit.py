"""The keys of the points screen that change its file: points and names, and steps of sequences.

None of them moves the arm, and none overwrites a change that another program has made.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from armdrive.errors import BadRequest
from armdrive.motion.plan import audit_opening
from armdrive.storage.points import Point, Step, StepList
from tui.desk import Desk
from tui.points.list import PointNaming, PointSelection
from tui.settings import SPEEDS, MoveSettings, neighbour

Change = Callable[[list[Step], int], str]
"""Changes the steps at a marked one, and says in words what was done."""


class StepEdits:
    """Changes of the chosen sequence, most of them at its marked step."""

    def __init__(
        self,
        desk: Desk,
        selection: PointSelection,
        require_standstill: Callable[[], None],
    ) -> None:
        """`require_standstill` raises `BadRequest` while the arm is under way."""
        self._desk = desk
        self._selection = selection
        self._require_standstill = require_standstill

    def mark(self, by: int) -> None:
        """Mark the next step, or the one before; the first press marks the first or the last."""
        steps = self._steps().steps
        before = self._selection.marked
        first = 0 if by > 0 else len(steps) - 1
        self._selection.mark(first if before is None else (before + by) % len(steps))

    def shift(self, by: int) -> None:
        """Carry the marked step out sooner or later: it changes places with its neighbour."""
        at, steps = self._marked()
        if not 0 <= at + by < len(steps.steps):
            end = "last" if by > 0 else "first"
            raise BadRequest(f"it is the {end} step of {self._selection.listed.name}")
        self._change(partial(_shifted, by=by))
        if self._selection.marked is not None:  # else another program had changed the sequence
            self._selection.mark(at + by)

    def drop(self) -> None:
        """Take the marked step out, after a second press."""
        at, steps = self._marked()
        effect = f"removes step {at + 1} ({steps.steps[at]}) from {self._selection.listed.name}"
        change = partial(self._change, _dropped)
        self._desk.confirmation.press(effect, change, row="points-step-drop")

    def shorten(self) -> None:
        """Take away the last step of the sequence; of a name being typed, the last letter."""
        if self._selection.naming is not None:
            self._selection.naming.line.erase()
            return
        name, steps = self._selection.listed.name, self._steps()
        shorter = StepList(steps.steps[:-1], steps.note)
        self._desk.arm.points.put_sequence(name, shorter, instead_of=steps)
        self._desk.say(f"the last step of {name} is removed: {steps.steps[-1]}")

    def add_grip(self) -> None:
        """Ask what the fingers shall do in a further step."""
        self._ask(PointNaming("gripper", "open", take=self._take, offered=True))

    def add_wait(self) -> None:
        """Ask how long a further step shall wait."""
        self._ask(PointNaming("wait", "1", take=self._take, offered=True))

    def change(self) -> None:
        """Ask what the marked step shall be instead."""
        at, steps = self._marked()
        purpose, text = _typed_for(steps.steps[at])
        offered = purpose != "to"  # the name of a point is corrected rather than replaced
        self._ask(PointNaming(purpose, text, take=self._take, offered=offered, changes=True))

    def retime(self, change: Callable[[Step], Step]) -> bool:
        """Change the way or the speed of the marked step; return whether one is marked."""
        at, steps = self._selection.marked, self._selection.listed.sequence
        if at is None or steps is None:
            return False
        self._change(partial(_changed, new=change(steps.steps[at])))
        return True

    def _steps(self) -> StepList:
        """Return the chosen sequence. Raises `BadRequest` without one that has steps."""
        steps = self._selection.listed.sequence
        if steps is None or not steps.steps:
            raise BadRequest("choose a sequence that has steps")
        return steps

    def _marked(self) -> tuple[int, StepList]:
        """Return the marked step and its sequence. Raises `BadRequest` where none is marked."""
        at, steps = self._selection.marked, self._selection.listed.sequence
        if at is None or steps is None:
            following, before = map(
                self._desk.keys.label, ("points-step-next", "points-step-previous")
            )
            raise BadRequest(f"mark a step of a sequence first: {following} or {before}")
        return at, steps

    def _ask(self, naming: PointNaming) -> None:
        if self._selection.listed.sequence is None:
            append = self._desk.keys.label("points-append")
            raise BadRequest(f"choose a sequence first; {append} on a point begins one")
        marked = self._selection.marked
        self._selection.ask(naming)
        self._selection.mark(marked)

    def _take(self, naming: PointNaming) -> None:
        """Put the step that was typed into the chosen sequence."""
        at, steps = self._selection.marked, self._selection.listed.sequence
        if steps is None or (naming.changes and at is None):
            self._selection.naming = None
            raise BadRequest(
                "another program has changed the sequence: look at it, and mark a step"
            )
        before = steps.steps[at] if naming.changes and at is not None else None
        opening_mm = self._desk.link.status.gripper_mm
        step = naming.step(opening_mm, before.speed if before else 1.0)
        if isinstance(step.gripper, float):
            audit_opening(self._desk.arm.config, step.gripper)
        if before is not None and step.point:
            step = replace(step, how=before.how)
        self._selection.naming = None  # only now: what was refused can still be corrected
        if before is not None:
            self._change(partial(_changed, new=step))
            return
        place = len(steps.steps) if at is None else at + 1
        self._write(partial(_added, new=step), place)
        if at is not None:
            self._selection.mark(place)

    def _change(self, change: Change) -> None:
        """Write the sequence with its marked step changed, unless a program has changed it."""
        if (at := self._selection.marked) is not None:
            self._write(change, at)

    def _write(self, change: Change, at: int) -> None:
        """Write the sequence changed at a place."""
        self._require_standstill()
        steps, name = self._selection.listed.sequence, self._selection.listed.name
        if steps is None:
            return
        changed = list(steps.steps)
        message = change(changed, at)
        new = StepList(tuple(changed), steps.note)
        self._selection.written = new
        self._desk.arm.points.put_sequence(name, new, instead_of=steps)
        self._desk.say(f"{name}: {message}")


class PointMotion:
    """How the arm goes to points: in a line or by a joint motion, and how fast."""

    def __init__(self, settings: MoveSettings, steps: StepEdits) -> None:
        self.line = False
        self._settings = settings
        self._steps = steps

    @property
    def speed(self) -> float:
        """The speed of planned moves."""
        return self._settings.speed

    def switch_line(self) -> None:
        """Switch between a straight line and a joint motion, also of a marked step."""
        if not self._steps.retime(_other_way):
            self.line = not self.line

    def change_speed(self, by: int) -> None:
        """Go faster or more slowly, also in a marked step."""
        if not self._steps.retime(partial(_other_speed, by=by)):
            self._settings.change_speed(by)


class PointEdits:
    """Changes of the chosen point, and of the list."""

    def __init__(self, desk: Desk, selection: PointSelection, motion: PointMotion) -> None:
        self._desk = desk
        self._selection = selection
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
            raise BadRequest("there is nothing to delete")
        self._confirm("points-delete", f"deletes {name}", change, f"{name} is deleted")

    def teach_again(self) -> None:
        """Move the chosen point to where the arm stands, after a second press."""
        name, _ = self._chosen("choose a point to teach again")

        def change() -> None:
            self._require_standing()
            self._desk.arm.points.teach(name, again=True)

        message = f"{name} is saved again, where the arm stands"
        self._confirm("points-again", f"moves {name} to where the arm stands", change, message)

    def teach(self) -> None:
        """Ask for the name of the place where the arm stands."""
        free = self._selection.listed.free_name()
        self._selection.ask(PointNaming("teach", free, take=self._teach, offered=True))

    def rename(self) -> None:
        """Ask for another name of the chosen point."""
        name, _ = self._chosen("choose a point to rename; sequences are renamed in the file")
        self._selection.ask(PointNaming("rename", name, take=self._rename))

    def append(self) -> None:
        """Ask for the sequence that the chosen point is put at the end of."""
        self._chosen("choose a point to put into a sequence")
        last = self._last_sequence
        self._selection.ask(PointNaming("append", last, take=self._append, offered=True))

    def move_there(self) -> None:
        """Ask for the chosen point on the move screen, to change it there."""
        mark = self._desk.keys.label("points-step-next")
        _, point = self._chosen(f"choose a point to change; {mark} marks a step of a sequence")
        self._desk.goal = point.joints
        self._desk.screens.show("move")

    def _chosen(self, otherwise: str) -> tuple[str, Point]:
        """Return the chosen point. Raises `BadRequest` with this sentence where there is none."""
        listed = self._selection.listed
        if listed.point is None:
            raise BadRequest(otherwise)
        return listed.name, listed.point

    def _confirm(self, row: str, effect: str, change: Callable[[], object], message: str) -> None:
        """Change the file and say so, after a second press."""

        def act() -> None:
            change()
            self._desk.say(message)

        self._desk.confirmation.press(effect, act, row=row)

    def _require_standing(self) -> None:
        """Raise `BadRequest` while the arm is somewhere on the way."""
        link = self._desk.link
        if link.moves and not link.status.paused:
            raise BadRequest("the arm is moving: wait until it stands")

    def _teach(self, naming: PointNaming) -> None:
        self._require_standing()
        self._selection.naming = None
        self._desk.arm.points.teach(naming.text)
        self._desk.say(f"{naming.text} is saved, where the arm stands")
        self._selection.choose_name(naming.text)  # once the list has been read again

    def _rename(self, naming: PointNaming) -> None:
        self._selection.naming = None
        before, name = self._selection.listed.name, naming.text
        self._desk.arm.points.rename(before, name)
        self._desk.say(f"{before} is called {name} now")
        self._selection.choose_name(name)

    def _append(self, naming: PointNaming) -> None:
        self._selection.naming = None
        self._last_sequence = name = naming.text
        listed, motion = self._selection.listed, self._motion
        before = listed.taught.sequences.get(name)
        step = Step(listed.name, "line" if motion.line else "joint", motion.speed)
        steps, note = ((), "") if before is None else (before.steps, before.note)
        made = StepList((*steps, step), note)
        self._desk.arm.points.put_sequence(name, made, instead_of=before)
        self._desk.say(f"step {len(made.steps)} of {name}: {step}")


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


def _typed_for(step: Step) -> tuple[str, str]:
    """Return what is typed to have another step in the place of this one, and what it says."""
    if step.point:
        return "to", step.point
    if step.wait_s is not None:
        return "wait", f"{step.wait_s:g}"
    return "gripper", step.gripper if isinstance(step.gripper, str) else f"{step.gripper:g}"


def _other_way(step: Step) -> Step:
    """Return the step with the other way to its point; raises `BadRequest` where it has none."""
    return replace(step, how="joint" if step.how == "line" else "line")


def _other_speed(step: Step, by: int) -> Step:
    """Return the step at the next speed of the table, faster or slower; the ends are the ends."""
    if step.wait_s is not None:
        raise BadRequest("a wait has no speed")
    return replace(step, speed=neighbour(SPEEDS, step.speed, by))
