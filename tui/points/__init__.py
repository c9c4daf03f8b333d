"""The points screen: shows saved points and sequences, goes to them, and steps through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.errors import BadRequest
from armdrive.moves import JointMove, LineMove, Motion
from armdrive.programs.teaching.sequence import Stepper
from armdrive.status import Status
from armdrive.storage.points import Point, StepList
from kinematics.geometry import ArmGeometry
from kinematics.text import counted
from tui.app import Job, TypedText
from tui.arm_view import SpaceView
from tui.desk import Desk, DeskScreen
from tui.keys.keyboard import Keyboard, bindings
from tui.keys.table import STOP, DeskKey, Needs, words
from tui.move.planned import PlannedMove, going_text, short_text
from tui.points.edit import PointEdits, PointMotion, StepEdits
from tui.points.list import PURPOSES, PointList, PointNaming, PointSelection
from tui.widgets import CURRENT_STYLE, DONE_STYLE, ChoiceList, Span, panels

StepCall = Callable[..., object]
"""Carries out a step; does nothing if a stop was asked for after the count `since`."""


class SequenceRun:
    """Carries out the chosen sequence. A stop that comes first lets a step not begin."""

    def __init__(self, desk: Desk) -> None:
        self.stepper: Stepper | None = None
        """Goes through the chosen sequence; None where a point or nothing is chosen."""
        self.stepping = False
        """Whether the step keys move the arm."""
        self.going = Job()
        """The steps that are being carried out."""
        self._desk = desk
        self._name = ""

    def follow(self, listed: PointList, *, same_row: bool) -> None:
        """Take what is chosen now; a sequence starts over unless its steps are the same."""
        self._name = listed.name
        stepper, steps = self.stepper, listed.sequence
        if stepper is not None and steps is not None and same_row and stepper.steps == steps.steps:
            stepper.points = listed.taught.points
        elif not self.going.busy:
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
        if self.going.busy:
            raise BadRequest(f"the arm is moving: {self._desk.keys.label(STOP)} stops it")

    def switch_stepping(self) -> None:
        """Let the step keys move the arm, or no longer."""
        self._require_stepper()
        self.stepping = not self.stepping

    def forward(self) -> None:
        """Carry out the next step."""
        self._press("goes on", self._require_stepper().forward)

    def backward(self) -> None:
        """Go back to the point before."""
        self._press("goes back", self._require_stepper().backward)

    def finish(self) -> None:
        """Carry out all steps that are left."""
        self._begin(self._require_stepper().run, self._desk.arm.stops)

    def rewind(self) -> None:
        """Start the sequence over. Moves nothing."""
        stepper = self._require_stepper()
        self.require_standstill()
        stepper.rewind()

    def _require_stepper(self) -> Stepper:
        """Return what goes through the chosen sequence; raises `BadRequest` without one."""
        if self.stepper is None:
            raise BadRequest("choose a sequence to step through")
        return self.stepper

    def _press(self, effect: str, step: StepCall) -> None:
        """Take one press of a step key.

        Raises `BadRequest` where the step keys do not move the arm.
        """
        if self.going.busy:
            self._desk.confirmation.refuse()  # it may still be held when the arm stands
        self.require_standstill()
        if not self.stepping:
            key = self._desk.keys.label("points-stepping")
            raise BadRequest(f"{key} lets this key move the arm")
        begin = partial(self._begin, step, self._desk.arm.stops)
        self._desk.confirmation.press(effect, begin, needed=1)

    def _begin(self, step: StepCall, stops: int) -> None:
        if self.stepper is not None:
            self._desk.arm.program = partial(_program, self._name, self.stepper)
        self.going = self._desk.calls.make(partial(self._carry_out, step, stops))

    def _carry_out(self, step: StepCall, stops: int) -> str:
        try:
            step(since=stops)  # a stop may come while this is on its way to the arm
        finally:
            self._desk.arm.program = None
        following = None if self.stepper is None else self.stepper.next
        return "the sequence is at its end" if following is None else f"next: {following}"


def _program(name: str, stepper: Stepper) -> dict[str, object]:
    """Return a sequence under way as it is reported to other programs."""
    step, steps = stepper.next or stepper.steps[-1], len(stepper.steps)
    line = min(stepper.at + 1, steps)
    return {"file": name, "line": line, "steps": steps, "text": str(step), "act": "step",
            "loop": 1, "loops": 1, "percent": None, "left_s": None}  # fmt: skip


NAME_WIDTH = 16
STEPS_SHOWN = 9
"""Steps of a sequence that are shown about the next one."""


def list_rows(listed: PointList, arm: ArmGeometry) -> list[str]:
    """Return a row for each point and sequence."""
    return [
        f"{name[:NAME_WIDTH]:<{NAME_WIDTH}} "
        + (
            f"sequence, {counted(len(listed.taught.sequences[name].steps), 'step')}"
            if is_sequence
            else _tip(listed.taught.points[name], arm)
        )
        for is_sequence, name in listed.rows
    ]


def none_yet(keys: Keyboard) -> str:
    """Say how the first point is made."""
    return f"no points yet: {keys.label('points-teach')} names the place where the arm stands"


def no_steps_yet(keys: Keyboard) -> str:
    """Say how an empty sequence gets a step."""
    append, grip = keys.label("points-append"), keys.label("points-grip")
    return f"no steps yet: {append} on a point appends it, {grip} a gripper step"


def _tip(point: Point, arm: ArmGeometry) -> str:
    x, y, z = arm.points(point.joints)[-1]
    return f"x {x:.0f}  y {y:.0f}  z {z:.0f}"


def point_text(point: Point) -> str:
    """Say all that is known of a point."""
    lines = [words(str(point.joints))]
    if point.opening_mm is not None:
        lines.append(f"gripper {point.opening_mm:.1f} mm (unchanged)")
    taught = "" if point.taught is None else f"taught {point.taught:%Y-%m-%d %H:%M}"
    lines += [part for part in (taught, point.note) if part]
    return "\n".join(lines)


def sequence_lines(
    stepper: Stepper, keys: Keyboard, *, stepping: bool, marked: int | None = None
) -> Iterator[Span]:
    """Lay the steps out around the next or the marked one, and say what the keys would do."""
    total, middle = len(stepper.steps), stepper.at if marked is None else marked
    first = max(min(middle - STEPS_SHOWN // 2, total - STEPS_SHOWN), 0)
    for index, step in enumerate(stepper.steps[first : first + STEPS_SHOWN], first):
        mark = (">" if index == stepper.at else " ") + ("*" if index == marked else " ")
        style = CURRENT_STYLE if index == stepper.at else DONE_STYLE * (index < stepper.at)
        yield f"{mark}{index + 1:>3} {'done ' * (index < stepper.at)}{step}", style
    for line in _step_keys(stepper, keys, stepping=stepping, marked=marked is not None):
        yield line, ""


def _step_keys(stepper: Stepper, keys: Keyboard, *, stepping: bool, marked: bool) -> Iterator[str]:
    if marked:
        drop, sooner = keys.label("points-step-drop"), keys.label("points-step-sooner")
        later, change = keys.label("points-step-later"), keys.label("points-step-change")
        yield f"* {change} changes it, {drop} twice: out; {sooner} {later}: sooner, later"
    grip, wait = keys.label("points-grip"), keys.label("points-wait")
    yield f"{grip} adds a gripper step, {wait} a wait"
    if stepper.at == len(stepper.steps):
        yield f"at its end: {keys.label('points-rewind')} starts over"
    switch = keys.label("points-stepping")
    if not stepping:
        yield f"{switch} goes through it step by step"
        return
    yield f"{switch}: STEPPING   {keys.label('points-forward')}: next step"
    if stepper.before is not None:
        yield f"{keys.label('points-backward')} back to {stepper.before[1]}"


def how_text(*, line: bool, speed: float, keys: Keyboard) -> str:
    """Say how the arm goes to a point."""
    way = "straight line" if line else "joint motion"
    slower, faster = keys.label("points-slower"), keys.label("points-faster")
    return f"{keys.label('points-line')}: {way}   {slower} {faster}: speed {speed:.0%}"


def naming_text(naming: PointNaming, keys: Keyboard) -> str:
    """Show the name as it is typed."""
    enter, stop = keys.label("points-go"), keys.label("stop")
    asked, reason = PURPOSES[naming.purpose]
    wrong = "" if naming.good or not naming.text else f"  ({reason})"
    hint = "  (or type another)" if naming.line.offered else wrong
    return f"{asked}: {naming.text}_{hint}\n{enter} takes it, {stop} drops it"


OF_POINTS = ("again", "rename", "edit", "line", "slower", "faster", "append")
OF_SEQUENCES = ("step-next", "grip", "wait", "stepping", "forward", "backward", "rewind")
"""Rows of the table of keys that are about the one alone, or mostly."""

OF_NONE = ("teach", "pause")
"""Rows that do something although nothing has been saved yet."""


class PointsScreen(DeskScreen):
    """The list, the chosen point or sequence, and the arm with the ghost of where it would go."""

    place = "points"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        desk = self.desk
        self.planned = PlannedMove(desk, self.goal)
        self.sequence = SequenceRun(desk)
        self.selection = PointSelection(desk, self._selection_changed)
        self.steps = StepEdits(desk, self.selection, self.sequence.require_standstill)
        self.motion = PointMotion(desk.settings.move, self.steps)
        self.points = PointEdits(desk, self.selection, self.motion)

    @property
    def typing(self) -> TypedText | None:
        """The name that is asked for."""
        return None if self.selection.naming is None else self.selection.naming.line

    def disarm(self, reason: str) -> None:
        """Let nothing go on that is not under way; a sequence ends after its step."""
        if self.selection.naming is not None:
            self.selection.naming = None
            self.desk.say(f"what you typed was dropped: {reason}")
        self.sequence.disarm()

    def _selection_changed(self, before: PointList) -> None:
        """Take back what was asked for while something else was seen to be chosen."""
        listed = self.selection.listed
        if _shown(before) != _shown(listed):
            self.desk.confirmation.forget()
        self.sequence.follow(listed, same_row=before.name == listed.name)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out."""
        with Horizontal():
            yield from self.arm_panel()
            with VerticalScroll(id="panels", can_focus=False):
                points = ChoiceList("choose", id="list")
                points.border_title = "Points and sequences"
                yield points
                yield from panels(
                    begin="Go",
                    chosen="Chosen",
                    how="How it is reached",
                    ahead="What the motion would be",
                )

    def goal(self) -> Motion | None:
        """Return the chosen point, or that of the next step of the chosen sequence."""
        listed, stepper = self.selection.listed, self.sequence.stepper
        point, line, speed = listed.point, self.motion.line, self.motion.speed
        step = stepper.next if stepper is not None and not self.sequence.going.busy else None
        if step is not None and step.point:
            point = listed.taught.points[step.point]
            line, speed = step.how == "line", step.speed
        if point is None:
            return None
        return (LineMove if line else JointMove)(point.joints, speed)

    def show_body(self, status: Status) -> None:
        """Show the list, what is chosen, and what the motion to it would be."""
        self.selection.reread()
        fresh = self.planned.follow(status)
        self.query_one(SpaceView).show(self.planned.moment(status, fresh))
        keys, arm = self.desk.keys, self.desk.arm.model.arm
        listed = self.selection.listed
        rows = list_rows(listed, arm)
        self.query_one(ChoiceList).show_rows(rows or [none_yet(keys)], listed.at if rows else None)
        self.text("chosen").show_lines(self._chosen_lines())
        self.text("chosen").display = bool(self.text("chosen").shown)
        self.show_panel("how", self._how_text())
        told = bool(self.desk.link.hindrance(Needs.POSITION))
        ahead = short_text(fresh, told=told) if fresh is not None else ""
        self.show_panel("ahead", self.desk.spoken(ahead))
        self.show_panel("begin", self._begin_text(status, fresh is not None))

    def _chosen_lines(self) -> Iterator[Span]:
        sequence, point = self.sequence, self.selection.listed.point
        if sequence.stepper is not None:
            yield from sequence_lines(
                sequence.stepper,
                self.desk.keys,
                stepping=sequence.stepping,
                marked=self.selection.marked,
            )
        elif point is not None:
            yield point_text(point), ""
        elif self.selection.listed.sequence is not None:
            yield no_steps_yet(self.desk.keys), ""

    def _how_text(self) -> str:
        if self.selection.listed.point is None:
            return ""
        motion = self.motion
        return how_text(line=motion.line, speed=motion.speed, keys=self.desk.keys)

    def _begin_text(self, status: Status, fresh: bool) -> str:
        keys = self.desk.keys
        if self.selection.naming is not None:
            return naming_text(self.selection.naming, keys)
        if self.sequence.going.busy:
            pause, stop = keys.label("points-pause"), keys.label(STOP)
            return going_text(pause, stop, paused=status.paused)
        if again := self.desk.confirmation.again:
            return again
        if self.sequence.stepper is not None:
            return f"{keys.label('points-go')} twice runs the remaining steps"
        return self.planned.text(status, self.planned.preview if fresh else None)

    @property
    def idle(self) -> tuple[str, ...]:
        """Keys of sequences do nothing to a point, and those of points nothing to a sequence.

        While a name is typed, the keys are its letters.
        """
        if self.selection.naming is not None or not self.selection.listed.rows:
            none = () if self.selection.naming is not None else OF_NONE
            all_ = (row.id for row in self.desk.keys.rows if row.place == self.place)
            return tuple(name for name in all_ if name.removeprefix("points-") not in none)
        others = OF_SEQUENCES if self.selection.listed.sequence is None else OF_POINTS
        return tuple(f"points-{name}" for name in others)

    def needs(self, row: DeskKey) -> Needs:
        """Return what a key needs of the arm: nothing while a name is typed."""
        return Needs.NOTHING if self.selection.naming is not None else super().needs(row)

    # -- keys ---------------------------------------------------------------------------------

    def action_choose(self, by: int) -> None:
        """Go to another row."""
        self.sequence.require_standstill()
        self.selection.show(self.selection.listed.moved(by))

    def action_press_go(self) -> None:
        """Take the name, or one press of the two that move the arm."""
        if (naming := self.selection.naming) is not None:
            naming.take(naming)
        elif self.sequence.stepper is None:
            self.planned.press()
        else:
            self.sequence.require_standstill()
            effect = "RUNS THE REMAINING STEPS"
            self.desk.confirmation.press(effect, self.sequence.finish, row="points-go")


def _shown(listed: PointList) -> tuple[str, Point | None, StepList | None]:
    """Return what a person sees to be chosen."""
    return listed.name, listed.point, listed.sequence
