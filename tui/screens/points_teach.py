"""The keys of the points screen that change its file: choosing, teaching, naming, deleting."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from textual import events

from armdrive.errors import ArmError
from armdrive.programs.teaching.sequence import Stepper
from armdrive.storage.points import Point, Step, StepList
from kinematics import KinematicsError
from tui.errand import Twice
from tui.point_list import Naming, PointList
from tui.screens.errands import ErrandScreen


class TeachKeys(ErrandScreen):
    """The list and the names. Nothing is written over what somebody else has changed."""

    def __init__(self) -> None:
        super().__init__()
        self.listed = PointList()
        self.line = False
        self.speed = 0.5
        self.naming: Naming | None = None
        self.stepper: Stepper | None = None
        self.stepping = False
        self.busy = False
        self.sure = Twice(self.desk.clock)
        self.sure_of = ""
        """What a second press of the same key would do, in words."""
        self._deed: Callable[[], None] = _nothing
        self._last_sequence = "sequence"
        self._stamp: object = ()

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
        self._ask_name(Naming("teach", self.listed.free_name(), offered=True))

    def action_rename(self) -> None:
        """Ask for another name of the chosen point."""
        if self.listed.point is None:
            self.desk.say("choose a point to rename; sequences are renamed in the file")
        else:
            self._ask_name(Naming("rename", self.listed.name))

    def action_append(self) -> None:
        """Ask for the sequence that the chosen point is put at the end of."""
        if self.listed.point is None:
            self.desk.say("choose a point to put into a sequence")
        else:
            self._ask_name(Naming("append", self._last_sequence, offered=True))

    def _ask_name(self, naming: Naming) -> None:
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

    def _named(self, naming: Naming) -> None:
        """Do what the name was asked for."""
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


def _shown(listed: PointList) -> tuple[str, Point | None, StepList | None]:
    """Return what a person sees to be chosen."""
    return listed.name, listed.point, listed.sequence


def _nothing() -> None:
    """Do nothing."""
