"""Carries the acts of a program out on an arm, by the public calls of that arm alone.

A stop ends the program at whatever moment it comes, also between two acts; an act that it broke off
has no answer and is the next one again. So does a suspension of this program or its computer,
unless a person lets it go on after that. While somebody has paused the arm, no act begins.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, cast

from armdrive.arm import Arm
from armdrive.arm.device import input_bits, output_bits
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.motion.gripper import Grasped
from armdrive.moves import GraspMove
from armdrive.programs.acts import (
    MOTIONS,
    Act,
    Answer,
    AwaitInputs,
    Delay,
    Go,
    Hold,
    Home,
    Look,
    Outputs,
    ProgramMove,
    ReadInput,
    Remember,
    RunStage,
    Say,
    act_name,
    waiting_text,
)
from armdrive.programs.language.values import PlaceValue
from armdrive.programs.program import Machine
from armdrive.programs.progress import FOR_EVER
from armdrive.runtime.overrides import given_up
from armdrive.storage.points import Point
from armdrive.text.json_forms import move_to_json
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints

SLICE_S = 0.05
"""Waits are cut into slices of this length, on the arm's clock, so that a stop ends them."""

POLL_S = 0.05
"""While a program waits for inputs, they are read so often, on the arm's clock."""

BREATH_S = 0.02
"""A paused program looks so often whether it may go on, in real time."""


class RunPerson(Protocol):
    """Whoever is at the terminal of a program that runs."""

    def say(self, text: str) -> None:
        """Show a line of text."""

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Wait until the person lets the program go on, or `over()` says that nobody waits."""


class Performer:
    """Carries out acts on one arm, for one run of a program.

    `since` is the arm's `stops` when the run was decided on: a later one ends it with `Stopped`.
    `outputs` is what is known of the output bits where the arm itself has not been told any.
    """

    def __init__(
        self, arm: Arm, person: RunPerson, *, since: int | None = None, outputs: int = 0
    ) -> None:
        self.arm = arm
        self.person = person
        self._stops = arm.stops if since is None else since
        self._outputs = outputs
        self._absences = self._absent()
        self._deeds: Mapping[type[Any], Callable[[Any], Answer]] = {
            Go: self._go,
            Home: self._home,
            Delay: self._delay,
            AwaitInputs: self._await_inputs,
            Hold: self._hold,
            Outputs: self._switch,
            ReadInput: self._read_input,
            Look: self._look,
            Remember: self._remember,
            Say: self._say,
        }

    def perform(self, act: Act) -> Answer:
        """Carry out an act and wait for its end; return its answer.

        Raises `Stopped`, what the arm's calls raise, and `kinematics.KinematicsError`.
        """
        self.wait_while_paused()
        answer = self._deeds[type(act)](act)
        self.require_no_stop()
        return answer

    def require_no_stop(self) -> None:
        """Raise `Stopped` where a stop was asked for since the run began."""
        if self.arm.stops != self._stops:
            raise Stopped("the program was stopped")
        if self._absent() != self._absences:
            raise Stopped(
                "the program was stopped: it or its computer had been suspended, and nothing goes "
                "on by itself after that"
            )

    def hold(self, text: str) -> None:
        """Wait until a person lets the program go on. Raises `Stopped`."""
        self.person.hold(text, lambda: self.arm.stops != self._stops)
        self._absences = self._absent()  # who let it go on has seen what is
        self.require_no_stop()

    def wait_while_paused(self) -> None:
        """Wait, in real time, for as long as somebody wants the arm to stand.

        Raises `WrongState` after as long as a motion would wait.
        """
        self.require_no_stop()
        if self.arm.paused:
            waited_s, longest_s = 0.0, self.arm.core.speed_override.longest_real_s
            while self.arm.paused:
                if waited_s >= longest_s:
                    raise given_up(waited_s)
                time.sleep(BREATH_S)
                waited_s += BREATH_S
            self._absences = self._absent()  # somebody let it go on
        self.require_no_stop()  # a stop ends a pause, too

    def _absent(self) -> int:
        with self.arm.pace.lock:
            return self.arm.engine.absences

    @property
    def outputs(self) -> int:
        """The output bits as they are known to be."""
        told = self.arm.status.outputs
        return self._outputs if told is None else told

    # -- what moves the arm -------------------------------------------------------------------

    def resolved(self, act: Act) -> ProgramMove | None:
        """Return the move of an act as it means the same from anywhere.

        None of an act that is no move, and of one that leads nowhere.
        """
        if not isinstance(act, Go):
            return None
        try:
            return cast(ProgramMove, self.arm.moving.resolved(act.move))
        except (ArmError, KinematicsError):
            return None

    def _go(self, act: Go) -> float | None:
        done = self.arm.start(act.move, stops=self._stops).wait()
        return done.width_mm if isinstance(done, Grasped) else None

    def _home(self, _: Home) -> None:
        if not self.arm.core.position_known:
            self.arm.home()

    # -- what waits ---------------------------------------------------------------------------

    def _delay(self, act: Delay) -> None:
        now_s = self.arm.pace.now_s
        end_s = now_s() + act.time_s
        while (left_s := end_s - now_s()) > 0.0:
            self.arm.sleep(min(left_s, SLICE_S))
            end_s += self._paused_s()

    def _paused_s(self) -> float:
        """Wait while the arm is paused; return how long, which is no part of any delay."""
        began_s = self.arm.pace.now_s()
        self.wait_while_paused()
        return self.arm.pace.now_s() - began_s

    def _await_inputs(self, act: AwaitInputs) -> bool:
        core = self.arm.core
        high, low = input_bits(core, act.high), input_bits(core, act.low)
        now_s = self.arm.pace.now_s
        end_s = math.inf if act.within_s is None else now_s() + act.within_s
        while True:
            bits = self.arm.read_inputs()
            if bits & high == high and not bits & low:
                return True
            left_s = end_s - now_s()
            if left_s <= 0.0:
                return False
            self.arm.sleep(min(POLL_S, left_s))
            end_s += self._paused_s()

    def _hold(self, act: Hold) -> None:
        self.hold(act.text)

    # -- what does neither --------------------------------------------------------------------

    def _switch(self, act: Outputs) -> None:
        bits = self.outputs & ~output_bits(act.off) | output_bits(act.on)
        self.arm.set_outputs(bits)
        self._outputs = bits

    def _read_input(self, act: ReadInput) -> bool:
        bit = input_bits(self.arm.core, act.number)
        return bool(self.arm.read_inputs() & bit)

    def _look(self, _: Look) -> PlaceValue:
        status = self.arm.status
        return PlaceValue(self.arm.pose, dict(self.arm.joints.deg), status.gripper_mm)

    def _remember(self, act: Remember) -> None:
        self.arm.points[act.name] = Point(joints_of(act.joints_deg, self.arm), act.opening_mm)

    def _say(self, act: Say) -> None:
        self.person.say(act.text)


def joints_of(angles_deg: Mapping[str, float], arm: Arm) -> Joints:
    """Return a posture by the names of the arm's joints. Raises `BadRequest` for other ones."""
    names = arm.model.arm.joint_names
    if set(angles_deg) != set(names):
        raise BadRequest(
            f"a place of this arm says {', '.join(names)}, not {', '.join(angles_deg) or 'nothing'}"
        )
    return Joints.of(*(angles_deg[name] for name in names), names=names)


# The run of a program: its machine gives acts, a performer carries them out, others look on.
#
# Whatever goes wrong is raised as it is; `at` is the step at which it did.


def no_machine() -> Machine:
    """Refuse to give the machine of what has none: a script."""
    raise BadRequest("a Python script has no acts")


@dataclass(frozen=True, slots=True)
class RunPlan:
    """What is to be run, and what its rehearsal assumes.

    `source` gives the machine of a loop, which stands at its beginning; `loops` is how many there
    are, `FOR_EVER` for no end. A program that is taken up stands in loop number `loop`, where
    `machine` gives it; `left` is what is left of its first move, and `outputs` is what it had
    switched.

    `inputs` say which inputs, counted from 1, are on and off; `width_mm` how wide is what the
    fingers find where no block is known, None for nothing. With `settle`, a position that nobody
    knows is assumed. With `traced` the tip's path is kept.
    """

    source: Callable[[], Machine] = no_machine
    loops: int = 1
    loop: int = 1
    machine: Callable[[], Machine] | None = None
    left: ProgramMove | None = None
    outputs: int = 0
    inputs: Mapping[int, bool] = field(default_factory=dict)
    width_mm: float | None = None
    settle: bool = False
    traced: bool = False

    @property
    def first(self) -> Callable[[], Machine]:
        """What gives the machine that the run begins with."""
        return self.machine or self.source


@dataclass(frozen=True, slots=True)
class RunStep:
    """One act of a run: `number` counts the acts of this run from 1, `loop` its loops.

    `move` is what the arm is to do, resolved from where it stands; None where it does not move, or
    will refuse to.
    """

    stage: RunStage
    number: int
    loop: int
    move: ProgramMove | None = None

    @property
    def act_name(self) -> str:
        """What people are told that the act is."""
        return act_name(self.stage.act)

    @property
    def waiting(self) -> str:
        """What the act waits for, as a person is told it; nothing for an act that goes on."""
        return waiting_text(self.stage.act)

    def view(self) -> dict[str, Any]:
        """Return its line, its act and its move as plain data."""
        return {
            "line": self.stage.mark.line,
            "act": self.act_name,
            "move": None if self.move is None else move_to_json(self.move),
        }

    @property
    def moves(self) -> bool:
        """Whether the act moves the arm."""
        return isinstance(self.stage.act, MOTIONS)

    @property
    def grasps(self) -> bool:
        """Whether the fingers close on what is between them."""
        return isinstance(self.move, GraspMove)


class Onlooker(Protocol):
    """Somebody who hears of every act before it begins and when it has ended."""

    def begins(self, step: RunStep, machine: Machine) -> None:
        """Hear of an act that is about to begin. What this raises ends the run before it."""

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Hear of an act that has ended well, and how long it took on the arm's own clock."""


class ProgramRun:
    """One run of a program, from its beginning or from where a machine stands."""

    def __init__(
        self, plan: RunPlan, performer: Performer, onlookers: Sequence[Onlooker] = ()
    ) -> None:
        self._plan = plan
        self._performer = performer
        self._onlookers = onlookers
        self.loop = plan.loop
        self.done = 0
        self.at: RunStep | None = None
        self.took_s = 0.0
        self._left = plan.left

    def carry_out(self) -> int:
        """Carry out everything that is left; return how many acts that was."""
        began_s = self._performer.arm.pace.now_s()
        loops, new_machine = self._plan.loops, self._plan.first
        while loops == FOR_EVER or self.loop <= loops:
            machine, new_machine = new_machine(), self._plan.source
            while (stage := machine.next()) is not None:
                self._carry_out(self._step(stage), machine)
            self.loop += 1
        self.at = None
        self.took_s = self._performer.arm.pace.now_s() - began_s
        return self.done

    def _step(self, stage: RunStage) -> RunStep:
        """Return the next step, its move resolved from where the arm stands."""
        self._performer.require_no_stop()
        left, self._left = self._left, None
        act = stage.act
        move = left if isinstance(act, Go) and left else self._performer.resolved(act)
        if isinstance(act, Go) and move is not None:
            stage = replace(stage, act=replace(act, move=move))
        return RunStep(stage, self.done + 1, self.loop, move)

    def _carry_out(self, step: RunStep, machine: Machine) -> None:
        self.at = step
        for onlooker in self._onlookers:
            onlooker.begins(step, machine)
        now_s = self._performer.arm.pace.now_s
        began_s = now_s()
        answer = self._performer.perform(step.stage.act)
        machine.answer(answer)
        self.done += 1
        for onlooker in self._onlookers:
            onlooker.ended(step, answer, now_s() - began_s)
