"""A program rehearsed on the arm's twin: the same acts by the same code, before anything moves.

What the twin cannot know is assumed, and said: inputs, the width of what is grasped, a position
that nobody knows. A refusal is part of the answer.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any, cast

from armdrive.arm import Arm
from armdrive.arm.device import input_bits
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmError, NotReferenced, Refused
from armdrive.moves import GraspMove
from armdrive.programs.acts import (
    Act,
    Answer,
    AwaitInputs,
    Delay,
    Go,
    Hold,
    Home,
    Outputs,
    ReadInput,
    Remember,
    Say,
)
from armdrive.programs.problems import SourceMark
from armdrive.programs.program import Machine
from armdrive.programs.progress import FOR_EVER, LOOPS_REHEARSED, Took
from armdrive.programs.running import Performer, ProgramRun, RunPlan, RunStep
from armdrive.registry.simulate import simulate
from armdrive.runtime.clock import PaceChoice
from armdrive.runtime.position import ArmCoordinates
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.sim.world.table import GripScene, Incident, TableBlock
from armdrive.status import State, Trust
from armdrive.trace.calls import NO_TRACER
from kinematics.errors import KinematicsError
from kinematics.geometry import Point

# The performer of a rehearsal: acts on the twin, and assumes what a twin cannot know.

WORDS = {True: "on", False: "off"}


NAP_S = 1.0
"""A twin sleeps no longer than this of a longer wait: nothing happens to it meanwhile."""


@dataclass(frozen=True, slots=True)
class Assumption:
    """Something that the twin could not know. `mark` is None of the arm itself.

    `matters` tells whether the program might go another way, or be refused elsewhere, if it is not
    so: a wait for a person only takes its time.
    """

    text: str
    mark: SourceMark | None = None
    matters: bool = True

    def __str__(self) -> str:
        return f"line {self.mark.line}: {self.text}" if self.mark is not None else self.text


class Assumptions:
    """What has been assumed, each thing once at each place of the program."""

    def __init__(self) -> None:
        self.found: list[Assumption] = []
        self.mark: SourceMark | None = None

    def note(self, text: str, *, matters: bool = True) -> None:
        """Note an assumption at the present place."""
        made = Assumption(text, self.mark, matters)
        if made not in self.found:
            self.found.append(made)


class UnattendedPerson:
    """The person of a rehearsal: hears nothing, and lets everything go on."""

    def say(self, text: str) -> None:
        """Hear nothing."""

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Let it go on."""


class Things:
    """What the fingers find where nobody knows what is around the arm.

    Always something `width_mm` wide, or nothing. Where the world around is `known` it is as it is.
    """

    def __init__(self, assumptions: Assumptions, width_mm: float | None, *, known: bool) -> None:
        self._assumptions = assumptions
        self._width_mm = width_mm
        self._known = known
        self._names = count(1)

    def before_grasp(self, arm: Arm) -> None:
        """Have between the fingers of a twin what they are assumed to find, if it fits in there."""
        if self._known or arm.twin is None:
            return
        if self._width_mm is None:
            self._assumptions.note("the fingers find nothing")
            return
        self._assumptions.note(f"the fingers find something {self._width_mm:g} mm wide")
        world = arm.twin.world
        if world.scene.held is None and world.opening_mm > self._width_mm:
            x_mm, y_mm, z_mm = world.tip
            name = f"assumed-{next(self._names)}"
            high_mm = 2.0 * max(z_mm, self._width_mm / 2.0)
            world.put(TableBlock(name, x_mm, y_mm, 0.0, self._width_mm, high_mm))


class Rehearser(Performer):
    """Carries out acts on a twin."""

    def __init__(
        self,
        twin: Arm,
        assumptions: Assumptions,
        *,
        inputs: Mapping[int, bool],
        things: Things,
        outputs: int = 0,
    ) -> None:
        super().__init__(twin, UnattendedPerson(), outputs=outputs)
        self._assumptions = assumptions
        self._inputs = inputs
        self._things = things

    def _go(self, act: Go) -> float | None:
        if isinstance(act.move, GraspMove):
            self._things.before_grasp(self.arm)
        return super()._go(act)

    def _read_input(self, act: ReadInput) -> bool:
        number = act.number
        input_bits(self.arm.core, number)  # the arm has to have it
        on = self._inputs.get(number, False)
        self._assumptions.note(f"input {number} is {WORDS[on]}", matters=number not in self._inputs)
        return on

    def _await_inputs(self, act: AwaitInputs) -> bool:
        """Take inputs to come at once, but for those that are said to be otherwise."""
        input_bits(self.arm.core, (*act.high, *act.low))
        on = all(self._inputs.get(number, True) for number in act.high)
        off = not any(self._inputs.get(number, False) for number in act.low)
        if (on and off) or act.within_s is None:
            self._assumptions.note(f"{act} at once")
            return True
        self._assumptions.note(f"it is not so within {act.within_s:g} s that {act}")
        self.arm.sleep(min(act.within_s, NAP_S))
        return False

    def _delay(self, act: Delay) -> None:
        self.arm.sleep(min(act.time_s, NAP_S))

    def _hold(self, act: Hold) -> None:  # noqa: ARG002 - as every hold
        self._assumptions.note("somebody lets it go on at once", matters=False)

    def _remember(self, act: Remember) -> None:
        """Leave the arm's points as they are."""


# Keeps the path of a simulated arm's tip, for the picture of a rehearsal.
#
# It is the physical path, whatever makes the arm move: acts of a program, and calls of a script.

NEAREST_MM = 1.0
"""Points of the path are no nearer to one another."""


class TracedScene:
    """The scene of an arm's world, which is told every motion of the tip; all else is its own."""

    def __init__(self, arm: Arm, scene: GripScene, path: list[Point]) -> None:
        self._arm = arm
        self._scene = scene
        self._path = path

    def follow(
        self, before: Point, after: Point, opening_mm: float, time_s: float
    ) -> list[Incident]:
        """Keep where the tip goes, once the arm knows where it stands."""
        if self._arm.core.position_known:
            for point in (before, after):
                if not self._path or math.dist(self._path[-1], point) >= NEAREST_MM:
                    self._path.append(point)
        return self._scene.follow(before, after, opening_mm, time_s)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)


def trace(arm: Arm, path: list[Point]) -> None:
    """Have a twin's tip leave its points in a path, in mm in the arm's base frame."""
    if arm.twin is not None:
        world = arm.twin.world
        world.scene = cast("GripScene", TracedScene(arm, world.scene, path))


# The twin that a program is rehearsed on: the arm's own, standing where the arm stands.
#
# A simulated arm is rehearsed in a copy of its world, blocks and all. Of a real one nobody knows
# what
# is around it: its twin stands alone. Where nobody knows where the arm stands, that is assumed, or
# left to the program, which has to reference it first.


def rehearsing_arm(
    config: ArmConfig,
    arm: Arm | None,
    assumed: Callable[[str], object] | None,
    clock: PaceChoice = None,
) -> Arm:
    """Return a connected twin of an arm on simulated time, enabled, which the caller closes.

    Without `arm` the arm itself cannot be asked. With `assumed`, a position that nobody knows is
    assumed, and `assumed` hears a sentence about it; without, the twin is as little referenced as
    the arm is. `clock` is one of simulated time that several twins share.
    """
    twin = _twin(config, arm)
    there = _known(arm)
    if there is None and assumed is not None:
        there, where = _supposed(config, arm)
        if there is not None:
            assumed(f"the arm stands in {where}")
    if there is not None:
        twin.device.bring_to(there.joints, there.opening_mm)
    made = Arm(connect_simulated(config, twin=twin, pace=clock, tracer=NO_TRACER))
    try:
        _make_ready(made, there)
        if arm is not None:
            made.speed_override = arm.speed_override
    except BaseException:
        made.close()
        raise
    return made


def knows_its_world(arm: Arm | None) -> bool:
    """Tell whether the world around an arm is known: that of a simulated one is."""
    return arm is not None and arm.twin is not None


def _twin(config: ArmConfig, arm: Arm | None) -> SimulatedArm:
    if arm is None or arm.twin is None:
        return simulate(config)
    with arm.pace.lock:
        saved = arm.twin.save()
    return simulate(config, saved)


def _make_ready(made: Arm, there: ArmCoordinates | None) -> None:
    if made.status.state is State.DISABLED:
        made.enable()
    if there is not None:
        made.declare_posture(there.joints, opening_mm=there.opening_mm)


def _known(arm: Arm | None) -> ArmCoordinates | None:
    """Return where an arm stands, if planned motion may begin there."""
    if arm is None:
        return None
    with arm.pace.lock:
        return arm.core.position.coordinates if arm.core.position_known else None


def _supposed(config: ArmConfig, arm: Arm | None) -> tuple[ArmCoordinates | None, str]:
    """Return where an arm may be taken to stand, and what that place is called."""
    if arm is not None and arm.status.trust is not Trust.UNKNOWN:
        with arm.pace.lock:
            return arm.core.position.coordinates, "the place where it was seen last"
    reference = config.model.reference
    if reference is not None:
        joints = config.model.arm.ik(reference.pose)
        return ArmCoordinates(joints, reference.opening_mm), "its reference posture"
    if config.homing is not None:
        return ArmCoordinates(config.homing.joints, config.homing.opening_mm), "its switches"
    return None, ""


MOST_ACTS = 20_000
"""A rehearsal that has come so far is long enough; programs may run for ever."""

MOST_S = 24 * 3600.0
"""So much of the arm's time is rehearsed at most."""

MOST_REAL_S = 60.0
"""So long a person waits for a rehearsal at most."""


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """What a rehearsal found.

    `loops` are its acts, a list a loop, with what each took; `refusal` is what it was refused
    with, at the mark `at`. `whole` is False where it was cut short: the program may never end.
    `share` of its speed was what the arm went with, `path` are the tip's points in mm, where they
    were asked for.
    """

    loops: tuple[tuple[Took, ...], ...]
    assumptions: tuple[Assumption, ...] = ()
    refusal: Exception | None = None
    at: SourceMark | None = None
    whole: bool = True
    share: float = 1.0
    path: tuple[Point, ...] = field(default=(), repr=False)

    @property
    def took_s(self) -> float:
        """How long the rehearsed loops took, on the arm's clock."""
        return sum(each.took_s for loop in self.loops for each in loop)

    @property
    def in_doubt(self) -> bool:
        """Whether the refusal follows from an assumption, perhaps."""
        return any(each.matters for each in self.assumptions)


class TooLong(BaseException):
    """The rehearsal has come far enough; no script that catches errors keeps it from ending."""


class Patience:
    """How long a rehearsal may go on, by its acts, by the arm's time, and by a person's."""

    def __init__(self) -> None:
        self._acts = 0
        self._until_s = time.monotonic() + MOST_REAL_S

    def ask(self, took_s: float) -> None:
        """Raise `TooLong` where it has gone on for long enough; asked for once before each act."""
        self._acts += 1
        too_many = self._acts > MOST_ACTS or took_s > MOST_S
        if too_many or time.monotonic() > self._until_s:
            raise TooLong


class _RehearsalWatch:
    """Notes what every act took, and ends what goes on for too long."""

    def __init__(self, assumptions: Assumptions) -> None:
        self.loops: dict[int, list[Took]] = {}
        self._assumptions = assumptions
        self._took_s = 0.0
        self._patience = Patience()

    def begins(self, step: RunStep, machine: Machine) -> None:  # noqa: ARG002 - as every onlooker
        """Say where the program is, to what is assumed there."""
        self._patience.ask(self._took_s)
        self._assumptions.mark = step.stage.mark

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Keep what it took."""
        took_s = _waited_s(step.stage.act, answer, took_s)
        self._took_s += took_s
        self.loops.setdefault(step.loop, []).append(Took(step.stage.mark, step.act_name, took_s))


def _waited_s(act: Act, answer: Answer, took_s: float) -> float:
    """Return what an act takes, of which a rehearsal sleeps only through the beginning."""
    if isinstance(act, Delay):
        return act.time_s
    if isinstance(act, AwaitInputs) and answer is False:
        return act.within_s or 0.0
    return took_s


def rehearse(config: ArmConfig, arm: Arm | None, plan: RunPlan) -> Rehearsal:
    """Rehearse a program on the twin of an arm. Sends nothing to the arm itself.

    Without `arm` it cannot be asked where it stands. Raises what reading the program raises, and
    `ArmError` for a twin that cannot be made.
    """
    assumptions = Assumptions()
    settles = plan.settle and not _references_first(plan)
    with rehearsing_arm(config, arm, assumptions.note if settles else None) as twin:
        rehearser = Rehearser(
            twin,
            assumptions,
            inputs=plan.inputs,
            things=Things(assumptions, plan.width_mm, known=knows_its_world(arm)),
            outputs=plan.outputs,
        )
        path: list[Point] = []
        if plan.traced:
            trace(twin, path)
        watch = _RehearsalWatch(assumptions)
        last = LOOPS_REHEARSED + plan.loop - 1
        loops = last if plan.loops == FOR_EVER else min(plan.loops, last)
        run = ProgramRun(replace(plan, loops=loops), rehearser, [watch])
        refusal, whole = _carried_out(run)
        if isinstance(refusal, NotReferenced) and arm is not None:
            refusal = _own_words(arm, refusal)
    return Rehearsal(
        tuple(tuple(watch.loops.get(number, ())) for number in range(1, loops + 1)),
        tuple(assumptions.found),
        refusal,
        run.at.stage.mark if refusal is not None and run.at is not None else None,
        whole,
        twin.speed_override,
        tuple(path),
    )


def _own_words(arm: Arm, refusal: NotReferenced) -> NotReferenced:
    """Return why the arm itself has no position to be trusted, of which its twin knows nothing."""
    try:
        arm.core.require_reference()
    except NotReferenced as own:
        return own
    return refusal


def _references_first(plan: RunPlan) -> bool:
    """Tell whether a program takes a reference before anything that needs one."""
    machine = plan.first()
    while (stage := machine.next()) is not None and isinstance(stage.act, Say | Delay | Outputs):
        machine.answer(None)
    return stage is not None and isinstance(stage.act, Home)


def _carried_out(run: ProgramRun) -> tuple[Exception | None, bool]:
    """Carry a rehearsal out; return what it was refused with, and whether it came to an end."""
    try:
        run.carry_out()
    except TooLong:
        return None, False
    except (ArmError, KinematicsError) as refusal:
        return refusal, True
    return None, True


def require_rehearsed(rehearsal: Rehearsal, *, anyway: bool) -> None:
    """Raise what a rehearsal was refused with, unless that may only follow from an assumption.

    Such a one is raised as a `Refused` that says so, unless the caller wants to go on `anyway`.
    """
    if rehearsal.refusal is None:
        return
    if not rehearsal.in_doubt:
        raise rehearsal.refusal
    if not anyway:
        first = next(each for each in rehearsal.assumptions if each.matters)
        raise Refused(
            f"the rehearsal failed: {rehearsal.refusal}. It had assumed that {first}; say what is "
            "so with --input and --assume-width, or run it all the same with --yes"
        ) from rehearsal.refusal
