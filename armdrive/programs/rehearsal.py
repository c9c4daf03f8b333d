"""A program rehearsed on the arm's twin: the same acts by the same code, before anything moves.

What the twin cannot know is assumed, and said: inputs, the width of what is grasped, a position
that nobody knows. A refusal is part of the answer.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from armdrive.errors import ArmError, NotReferenced, Refused
from armdrive.programs.acts import (
    Act,
    Answer,
    AwaitInputs,
    Delay,
    Home,
    Machine,
    Mark,
    Outputs,
    Say,
)
from armdrive.programs.progress import LOOPS_REHEARSED, Took
from armdrive.programs.rehearsing import Assumption, Assumptions, Rehearser, Things
from armdrive.programs.running import FOR_EVER, Run, Source, Step
from armdrive.programs.twins import knows_its_world, rehearsing_arm
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.armfile import ArmConfig
    from kinematics.geometry import Point

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
    at: Mark | None = None
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


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be rehearsed, and on which assumptions.

    `inputs` say which inputs, counted from 1, are on and off; `width_mm` how wide is what the
    fingers find where no block is known, None for nothing. With `settle`, a position that nobody
    knows is assumed. With `traced` the tip's path is kept.
    """

    source: Source
    loops: int = 1
    loop: int = 1
    machine: Callable[[], Machine] | None = None
    inputs: Mapping[int, bool] = field(default_factory=dict)
    width_mm: float | None = None
    outputs: int = 0
    settle: bool = False
    traced: bool = False


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


class _Watch:
    """Notes what every act took, and ends what goes on for too long."""

    def __init__(self, assumptions: Assumptions) -> None:
        self.loops: dict[int, list[Took]] = {}
        self._assumptions = assumptions
        self._took_s = 0.0
        self._patience = Patience()

    def begins(self, step: Step, machine: Machine) -> None:  # noqa: ARG002 - as every onlooker
        """Say where the program is, to what is assumed there."""
        self._patience.ask(self._took_s)
        self._assumptions.mark = step.stage.mark

    def ended(self, step: Step, answer: Answer, took_s: float) -> None:
        """Keep what it took."""
        took_s = _waited_s(step.stage.act, answer, took_s)
        self._took_s += took_s
        self.loops.setdefault(step.loop, []).append(
            Took(step.stage.mark, type(step.stage.act).__name__, took_s)
        )


def _waited_s(act: Act, answer: Answer, took_s: float) -> float:
    """Return what an act takes, of which a rehearsal sleeps only through the beginning."""
    if isinstance(act, Delay):
        return act.time_s
    if isinstance(act, AwaitInputs) and answer is False:
        return act.within_s or 0.0
    return took_s


def rehearse(config: ArmConfig, arm: Arm | None, plan: Plan) -> Rehearsal:
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
            traced=plan.traced,
            outputs=plan.outputs,
        )
        watch = _Watch(assumptions)
        last = LOOPS_REHEARSED + plan.loop - 1
        loops = last if plan.loops == FOR_EVER else min(plan.loops, last)
        machine = None if plan.machine is None else plan.machine()
        run = Run(plan.source, rehearser, [watch], loops=loops, loop=plan.loop, machine=machine)
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
        tuple(rehearser.path),
    )


def _own_words(arm: Arm, refusal: NotReferenced) -> NotReferenced:
    """Return why the arm itself has no position to be trusted, of which its twin knows nothing."""
    try:
        arm.core.require_reference()
    except NotReferenced as own:
        return own
    return refusal


def _references_first(plan: Plan) -> bool:
    """Tell whether a program takes a reference before anything that needs one."""
    machine = plan.source.machine() if plan.machine is None else plan.machine()
    while (stage := machine.next()) is not None and isinstance(stage.act, Say | Delay | Outputs):
        machine.answer(None)
    return stage is not None and isinstance(stage.act, Home)


def _carried_out(run: Run) -> tuple[Exception | None, bool]:
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
