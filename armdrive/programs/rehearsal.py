"""Rehearses a program on the arm's simulated twin: the same acts by the same code.

`rehearse` makes a twin that stands where the arm stands (`rehearsing_arm`), and has a `ProgramRun`
carry the acts out on it: the `Rehearser` is a performer that makes assumptions, and a
`_RehearsalWatch` notes how long each act takes and ends what would never end.

The twin cannot know the inputs, the width of an object to be grasped, or an unknown position. It
assumes them, and lists its assumptions. A refusal is part of the result.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count
from typing import Any

from armdrive.arm import Arm
from armdrive.arm.device import input_bits
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import Target
from armdrive.errors import ArmError, NotReferenced, Refused
from armdrive.errors.table import error_view
from armdrive.moves import GraspMove
from armdrive.programs.acts import (
    Answer,
    AwaitInputs,
    Delay,
    Go,
    Hold,
    Home,
    Look,
    ReadInput,
    Remember,
    RunStep,
)
from armdrive.programs.problems import SourceLines, SourceMark
from armdrive.programs.program import Machine
from armdrive.programs.progress import (
    FOR_EVER,
    LOOPS_REHEARSED,
    RunProgress,
    Took,
    duration,
    line_words,
)
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.registry import simulate
from armdrive.runtime.clock import PaceChoice
from armdrive.runtime.position import ArmCoordinates
from armdrive.sim.world.table import TableBlock
from armdrive.status import Trust
from armdrive.tasks import Difference
from kinematics.errors import KinematicsError
from kinematics.geometry import Point
from kinematics.text import counted

# What a person says beforehand, and the performer: carries out acts on the twin, and assumes.


@dataclass(frozen=True, slots=True)
class RehearsalOptions:
    """The options of a rehearsal.

    `inputs` are the known inputs, counted from 1. `width_mm` is the width of the objects that the
    fingers find if no block is known, None if they find none. With `settle` an unknown position is
    assumed; with `traced` the tip's path is recorded.
    """

    inputs: Mapping[int, bool] = field(default_factory=dict)
    width_mm: float | None = None
    settle: bool = False
    traced: bool = False


DEFAULT_OPTIONS = RehearsalOptions()

# The longest sleep of a twin: during a longer wait nothing more happens to it.
NAP_S = 1.0


@dataclass(frozen=True, slots=True)
class Assumption:
    """Something that the twin could not know. `mark` is None if it concerns the arm itself.

    `matters` says whether a wrong assumption could change the path of the program or a refusal; a
    wait for a person only takes longer.
    """

    text: str
    mark: SourceMark | None = None
    matters: bool = True

    def __str__(self) -> str:
        return f"line {self.mark.line}: {self.text}" if self.mark is not None else self.text


class UnattendedPerson:
    """The person of a rehearsal, who continues every program at once."""

    def say(self, text: str) -> None:
        """Ignore the text."""

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Return at once."""


KNOWN_OBJECTS = "the fingers find what the simulated world has there, and not the assumed width"


class Rehearser(Performer):
    """Carries out acts on a twin of the arm that was `seen`, and lists what it assumes for that.

    Each assumption is listed once for each place in the program.
    """

    def __init__(self, twin: Arm, seen: SeenArm, options: RehearsalOptions, outputs: int) -> None:
        super().__init__(twin, UnattendedPerson(), outputs=outputs)
        if options.inputs:
            # raises for an input that the arm does not have
            input_bits(twin.parts.core, tuple(options.inputs))
        self.assumptions: list[Assumption] = []
        self.mark: SourceMark | None = None
        self.path: list[Point] = []
        self._seen = seen
        self._options = options
        self._switched: set[int] = set()
        self._objects = count(1)

    def assume(self, text: str, *, matters: bool = True) -> None:
        """List an assumption at the present place."""
        made = Assumption(text, self.mark, matters)
        if made not in self.assumptions:
            self.assumptions.append(made)

    @property
    def fingerprint(self) -> object:
        """A key that is equal for equal states of the twin and its world."""
        there, twin = self.arm.parts.core.position.coordinates, self.arm.twin
        if twin is None:
            return there.values
        scene = twin.world.scene
        blocks = (
            (block.name, *(round(at_mm, 1) for at_mm in block.place))
            for block in scene.blocks.values()
        )
        return (there.values, self.outputs, scene.held, *blocks)

    def switch(self, inputs: set[int]) -> bool:
        """Switch on inputs of which nothing is known; return whether there were any left."""
        fresh = inputs - self._options.inputs.keys() - self._switched
        self._switched |= fresh
        return bool(fresh)

    def _go(self, act: Go) -> float | None:
        if isinstance(act.move, GraspMove):
            self._put_object()
        elif self._options.traced:
            self.path += self.arm.preview(act.move).path
        return super()._go(act)

    def _put_object(self) -> None:
        """Put the assumed object between the fingers, if it fits there."""
        width_mm, twin = self._options.width_mm, self.arm.twin
        if self._seen.world is not None or twin is None:
            if width_mm is not None:
                self.assume(KNOWN_OBJECTS, matters=False)
            return
        if width_mm is None:
            self.assume("the fingers find nothing")
            return
        self.assume(f"the fingers find something {width_mm:g} mm wide")
        world = twin.world
        if world.scene.held is None and world.opening_mm > width_mm:
            x_mm, y_mm, z_mm = world.tip
            high_mm = 2.0 * max(z_mm, width_mm / 2.0)
            name = f"assumed-{next(self._objects)}"
            world.put(TableBlock(name, x_mm, y_mm, 0.0, width_mm, high_mm))

    def _home(self, _: Home) -> None:
        # of an arm whose position was only assumed, the run takes the reference
        if self._seen.position is None or not self.arm.parts.core.position_known:
            self.arm.home()

    def _read_input(self, act: ReadInput) -> bool:
        number, known = act.number, self._options.inputs
        input_bits(self.arm.parts.core, number)  # raises for an input that the arm does not have
        later = " later" if number in self._switched else ""
        on = known.get(number, number in self._switched)
        self.assume(
            f"input {number} is {'on' if on else 'off'}{later}", matters=number not in known
        )
        return on

    def _await_inputs(self, act: AwaitInputs) -> bool:
        """Assume that inputs come at once, except those that the person has set."""
        known = self._options.inputs
        input_bits(self.arm.parts.core, (*act.high, *act.low))
        on = all(known.get(number, True) for number in act.high)
        off = not any(known.get(number, False) for number in act.low)
        if (on and off) or act.within_s is None:
            self.assume(f"{act} at once")
            return True
        self.assume(f"in {act.within_s:g} s it does not happen that {act}")
        self.arm.sleep(min(act.within_s, NAP_S))
        return False

    def _delay(self, act: Delay) -> None:
        self.arm.sleep(min(act.time_s, NAP_S))

    def _hold(self, act: Hold) -> None:  # noqa: ARG002 - as every hold
        self.assume("a person continues it at once", matters=False)

    def _remember(self, act: Remember) -> None:
        """Leave the arm's points as they are."""


# The twin that a program is rehearsed on: a simulated arm that stands where the arm stands.
#
# A simulated arm is rehearsed in a copy of its world, blocks and all. Around a real arm nothing is
# known, so its twin stands alone. If the position is unknown, the rehearsal assumes one, or leaves
# it to the program to reference the arm first.


@dataclass(frozen=True, slots=True)
class SeenArm:
    """All that a rehearsal needs to know about an arm, so that the arm itself can be let go.

    `position` is where the arm stands, if planned motion may begin there; `distrust` says why it
    may not. `last_seen` is the position before trust in it was lost. `world` is a saved copy of a
    simulated arm's world. Without `geometry_known`, Cartesian goals are refused, and with some
    `differences` between the controller's settings and the arm file, all motion.
    """

    config: ArmConfig
    position: ArmCoordinates | None = None
    last_seen: ArmCoordinates | None = None
    world: Mapping[str, object] | None = None
    speed_override: float = 1.0
    distrust: NotReferenced | None = None
    geometry_known: bool = True
    differences: tuple[Difference, ...] = ()

    @classmethod
    def unasked(cls, target: Target) -> SeenArm:
        """Return what the arm file says about an arm that is not connected."""
        config = target.config
        return cls(config, geometry_known=target.simulated or config.model.verified)

    @classmethod
    def of(cls, arm: Arm) -> SeenArm:
        """Look at a connected arm."""
        distrust = None
        try:
            arm.parts.core.require_reference()
        except NotReferenced as error:
            distrust = error
        # the position and the copy of the world have to be of one moment
        with arm.parts.pace.lock:
            there = arm.parts.core.position.coordinates
            return cls(
                arm.config,
                there if arm.parts.core.position_known else None,
                None if arm.status.trust is Trust.UNKNOWN else there,
                None if arm.twin is None else arm.twin.save(),
                arm.speed_override,
                distrust,
                arm.parts.core.geometry_known,
                arm.parts.core.differences,
            )


def rehearsing_arm(
    seen: SeenArm, assumed: Callable[[str], object] | None, clock: PaceChoice = None
) -> Arm:
    """Return an enabled, connected twin of an arm on simulated time; the caller closes it.

    With `assumed`, an unknown position is replaced by a likely one, and `assumed` is called with a
    sentence about it. Without, the twin's position is as unknown as the arm's. Several twins may
    share a simulated `clock`.
    """
    config = seen.config
    twin = simulate(config, seen.world)
    there = seen.position
    if there is None and assumed is not None:
        there, where = _likely_position(seen)
        if there is not None:
            assumed(f"the arm stands in {where}")
    if there is not None:
        twin.device.bring_to(there.joints, there.opening_mm)
    made = Arm(connect_simulated(config, twin=twin, pace=clock))
    core = made.parts.core
    core.geometry_known = seen.geometry_known  # the twin knows no more than the arm itself
    try:
        if seen.world is None:
            made.reset()  # a board that homes is locked when it has just been switched on
        made.enable()
        if there is not None:
            made.reference.declare(there.joints, opening_mm=there.opening_mm)
        made.speed_override = seen.speed_override
        core.differences = seen.differences
    except BaseException:
        made.close()
        raise
    return made


def _likely_position(seen: SeenArm) -> tuple[ArmCoordinates | None, str]:
    """Return where an arm probably stands, and what that place is called."""
    if seen.last_seen is not None:
        return seen.last_seen, "the place where it was last seen"
    model, homing = seen.config.model, seen.config.homing
    if model.reference is not None:
        joints = model.arm.ik(model.reference.pose)
        return ArmCoordinates(joints, model.reference.opening_mm), "its reference posture"
    if homing is not None:
        return ArmCoordinates(homing.joints, homing.opening_mm), "its switches"
    return None, ""


# How long a rehearsal takes.

# Real time. The arm is held while a program is rehearsed before it runs.
BEFORE_RUN_S = 5.0

# Real time. A person who only checks a program waits longer, and the arm is free meanwhile.
CHECK_S = 10.0


class TooLong(BaseException):
    """The rehearsal has used up its time."""


class EndlessLoop(BaseException):
    """The program has come back to a state that it was in before; `mark` is where the loop is."""

    def __init__(self, mark: SourceMark) -> None:
        super().__init__()
        self.mark = mark


def time_limit(limit_s: float) -> Callable[[], bool]:
    """Return a function that returns whether this much real time has passed."""
    end_s = time.monotonic() + limit_s
    return lambda: time.monotonic() > end_s


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """What a rehearsal found.

    `loops` has a list for each loop: its acts and how long each took. `refusal` is the error that
    ended the rehearsal, at the mark `at`. `endless` is where the program repeats endlessly.
    `whole` is False if the time was up before the end. The arm moved with `share` of its speed;
    `path` has the tip's points in mm, if they were asked for.
    """

    loops: tuple[tuple[Took, ...], ...]
    assumptions: tuple[Assumption, ...] = ()
    refusal: Exception | None = None
    at: SourceMark | None = None
    whole: bool = True
    endless: SourceMark | None = None
    share: float = 1.0
    path: tuple[Point, ...] = field(default=(), repr=False)

    @property
    def took_s(self) -> float:
        """How long the rehearsed loops took, on the arm's clock."""
        return sum(each.took_s for loop in self.loops for each in loop)

    def by_line(self) -> list[tuple[int, int, Took]]:
        """Return each line, how often it is carried out, and its acts together.

        The looks that a line takes for itself are not counted.
        """
        lines: dict[int, list[Took]] = {}
        for each in chain.from_iterable(self.loops):
            lines.setdefault(each.mark.line, []).append(each)
        found = []
        for line, took in lines.items():
            times = len([each for each in took if each.what != Look.__name__]) or len(took)
            total_s = sum(each.took_s for each in took)
            found.append((line, times, replace(took[0], took_s=total_s)))
        return found

    @property
    def end_words(self) -> str:
        """How it ended, if not at the end of the program, as people read it."""
        if self.endless is not None:
            return f"; endless: it repeats from line {self.endless.line} on"
        return "" if self.whole else "; not rehearsed to its end, which would take too long"

    def progress(self, loops: int) -> RunProgress:
        """Return what estimates how far a run of `loops` loops has come."""
        known = self.whole and self.endless is None and self.refusal is None
        return RunProgress(self.loops if known else (), repeated=loops)

    @property
    def in_doubt(self) -> bool:
        """Whether the refusal may only follow from an assumption."""
        return any(each.matters for each in self.assumptions)


class _RehearsalWatch:
    """Notes how long every act takes, and ends a rehearsal that takes too long or goes in circles.

    The twin and the program are deterministic. So a program that comes back to a state in which it
    was before, with the twin as it was then, repeats endlessly.
    """

    def __init__(self, rehearser: Rehearser, over: Callable[[], bool]) -> None:
        self.loops: dict[int, list[Took]] = {}
        self._rehearser = rehearser
        self._over = over
        self._steps: list[RunStep] = []
        self._before: dict[object, int] = {}

    def begins(self, step: RunStep, machine: Machine) -> None:
        """Note where the program is. Raises `TooLong` and `EndlessLoop`."""
        mark = step.mark
        if self._over():
            raise TooLong
        self._rehearser.mark = mark
        state = (step.loop, machine.fingerprint, self._rehearser.fingerprint)
        since = self._before.setdefault(state, len(self._steps))
        if since < len(self._steps):
            self._went_round(self._steps[since:])
        self._steps.append(step)

    def _went_round(self, steps: Sequence[RunStep]) -> None:
        """Switch the inputs that a loop reads: it waits for one of them. Else it has no end."""
        acts = (step.act for step in steps)
        if not self._rehearser.switch({act.number for act in acts if isinstance(act, ReadInput)}):
            raise EndlessLoop(min((step.mark for step in steps), key=lambda mark: mark.line))

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Note how long the act took."""
        if isinstance(step.act, Delay):  # of a wait, the twin sleeps through the beginning only
            took_s = step.act.time_s
        elif isinstance(step.act, AwaitInputs) and answer is False:
            took_s = step.act.within_s or 0.0
        self.loops.setdefault(step.loop, []).append(Took(step.mark, step.name, took_s))


def rehearse(
    seen: SeenArm,
    plan: RunPlan,
    over: Callable[[], bool],
    options: RehearsalOptions = DEFAULT_OPTIONS,
) -> Rehearsal:
    """Rehearse a program on the twin of an arm. Sends nothing to the arm itself.

    It ends before the act at which `over()` is true, such as after a `time_limit`.
    Raises what reading the program raises, and `ArmError` if the twin cannot be made.
    """
    assumed: list[str] = []
    with rehearsing_arm(seen, assumed.append if options.settle else None) as twin:
        rehearser = Rehearser(twin, seen, options, plan.outputs)
        for text in assumed:
            rehearser.assume(text)
        watch = _RehearsalWatch(rehearser, over)
        # a program that is resumed may begin in a later loop
        last = LOOPS_REHEARSED + plan.loop - 1
        loops = last if plan.loops == FOR_EVER else min(plan.loops, last)
        run = ProgramRun(
            replace(plan, loops=loops), rehearser, before=[watch.begins], after=[watch.ended]
        )
        refusal: Exception | None = None
        whole, endless = True, None
        try:
            run.carry_out()
        except TooLong:
            whole = False
        except EndlessLoop as found:
            endless = found.mark
        except NotReferenced as error:  # the arm's own reason says more than its twin's
            refusal = seen.distrust or error
        except (ArmError, KinematicsError) as error:
            refusal = error
    return Rehearsal(
        tuple(tuple(watch.loops.get(number, ())) for number in range(1, loops + 1)),
        tuple(rehearser.assumptions),
        refusal,
        run.at.mark if refusal is not None and run.at is not None else None,
        whole,
        endless,
        twin.speed_override,
        tuple(rehearser.path),
    )


def require_rehearsed(rehearsal: Rehearsal, *, anyway: bool) -> None:
    """Raise the refusal of a rehearsal.

    A refusal that may only follow from an assumption is raised as a `Refused` that says so, and not
    at all if the caller wants to run the program `anyway`.
    """
    if rehearsal.refusal is None:
        return
    if not rehearsal.in_doubt:
        raise rehearsal.refusal
    if not anyway:
        first = next(each for each in rehearsal.assumptions if each.matters)
        raise Refused(
            "the rehearsal failed, perhaps only because of what it assumed, "
            f"{first}; give the real values with --input and --assume-width, or run it all the "
            f"same with --yes. What failed: {rehearsal.refusal}"
        ) from rehearsal.refusal


# A rehearsal in words, and as plain data.


def rehearsal_lines(rehearsal: Rehearsal, lines: SourceLines) -> list[str]:
    """Return a rehearsal as lines of text: what each line takes, and how often."""
    found = []
    for line, times, took in rehearsal.by_line():
        repeated = f" x {times}" if times > 1 else ""
        text = lines.get((took.mark.file, line), took.what).strip()
        found.append(f"{duration(took.took_s / times):>12}{repeated:<6} {line_words(line, text)}")
    acts = counted(sum(map(len, rehearsal.loops)), "act")
    found.append(f"{duration(rehearsal.took_s):>12} for {acts}{rehearsal.end_words}")
    return found + [f"assumed: {each}" for each in rehearsal.assumptions]


def rehearsal_view(rehearsal: Rehearsal) -> dict[str, Any]:
    """Return a rehearsal as plain data."""
    refusal, at = rehearsal.refusal, rehearsal.at
    return {
        "took_s": round(rehearsal.took_s, 3),
        "acts": sum(map(len, rehearsal.loops)),
        "whole": rehearsal.whole,
        "endless": None if rehearsal.endless is None else rehearsal.endless.line,
        "lines": [
            {"line": line, "times": times, "took_s": round(took.took_s, 3)}
            for line, times, took in rehearsal.by_line()
        ],
        "assumptions": [
            {
                "line": None if each.mark is None else each.mark.line,
                "text": each.text,
                "matters": each.matters,
            }
            for each in rehearsal.assumptions
        ],
        "refused": None if refusal is None else error_view(refusal),
        "line": None if at is None else at.line,
    }
