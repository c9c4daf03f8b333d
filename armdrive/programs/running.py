"""Carries out the acts of a program on an arm, using only the arm's public calls.

`ProgramRun` takes acts from a machine, and calls others before and after each; a `Performer`
carries an act out; `Waits` ends every wait at a stop, and lengthens it by a pause.

A stop ends the program at any moment, also between two acts. An interrupted act has no answer, so a
resumed program repeats it. A suspension of this process or its computer also ends the program,
unless a person then continues it. While the arm is paused, no act begins.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, TypeAlias, cast

from armdrive.arm import Arm
from armdrive.arm.device import input_bits, output_bits
from armdrive.arm.moving import ground_of
from armdrive.errors import ArmError, BadRequest, InputTimeout, Stopped
from armdrive.motion.gripper import Grasped
from armdrive.motion.resolve import resolved
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
    RunStep,
    Say,
    act_name,
    waiting_text,
)
from armdrive.programs.language.values import PlaceValue
from armdrive.programs.program import Machine
from armdrive.programs.progress import FOR_EVER
from armdrive.runtime.overrides import given_up
from armdrive.storage.points import Point
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints

# The waits of a run: a pause lengthens them, a stop or a suspension ends them.

# The longest sleep of a wait, on the arm's clock: between two sleeps a stop ends it.
SLICE_S = 0.05

# The time between two looks of a paused program whether it may go on, in real time.
BREATH_S = 0.02


class Waits:
    """The waits of one run on one arm.

    `since`, then `stops`, is the arm's count of `stops` when the run was decided on: a later stop
    ends the run.
    """

    def __init__(self, arm: Arm, *, since: int | None = None) -> None:
        self._arm = arm
        self._runner, self._pace = arm.parts.runner, arm.parts.pace
        self.stops = arm.stops if since is None else since
        self._runner.know_of(self.stops)
        self._absences = self._runner.absences()

    @property
    def stopped(self) -> bool:
        """Whether a stop was requested since the run began."""
        return self._arm.stops != self.stops

    def require_no_stop(self) -> None:
        """Raise `Stopped` after a stop or a suspension since the run began."""
        if self.stopped:
            raise Stopped("the program was stopped")
        self._runner.require_present(self._absences)

    def attended(self) -> None:
        """Note that a person has just seen the arm. Raises `Stopped`."""
        self._absences = self._runner.absences()
        self.require_no_stop()

    def delay(self, time_s: float) -> None:
        """Wait this long on the arm's clock, not counting pauses. Raises `Stopped`."""
        now_s = self._pace.now_s
        end_s = now_s() + time_s
        while (left_s := end_s - now_s()) > 0.0:
            self._arm.sleep(min(left_s, SLICE_S))
            end_s += self.paused_s()

    def paused_s(self) -> float:
        """Wait while the arm is paused; return how long, which extends a wait."""
        began_s = self._pace.now_s()
        self.while_paused()
        return self._pace.now_s() - began_s

    def while_paused(self) -> None:
        """Wait, in real time, for as long as the arm is paused.

        Raises `Stopped`, and `WrongState` after the time that a motion would wait.
        """
        if self._arm.status.paused:
            waited_s, longest_s = 0.0, self._arm.parts.core.speed_override.longest_real_s
            while self._arm.status.paused:
                if waited_s >= longest_s:
                    raise given_up(waited_s)
                time.sleep(BREATH_S)
                waited_s += BREATH_S
            self._absences = self._runner.absences()  # a person ended the pause
        self.require_no_stop()  # a stop ends a pause, too


# The acts, carried out.


class RunPerson(Protocol):
    """The person at the terminal of a running program."""

    def say(self, text: str) -> None:
        """Show a line of text."""

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Wait until the person continues the program, or `over()` is true."""


class Performer:
    """Carries out acts on one arm, for one run of a program.

    `since` is the arm's count of `stops` when the run was decided on: a later stop ends the run
    with `Stopped`. `outputs` are the output bits of an earlier run, used until the arm sets others.
    """

    def __init__(
        self, arm: Arm, person: RunPerson, *, since: int | None = None, outputs: int = 0
    ) -> None:
        self.arm = arm
        self.person = person
        self._outputs = outputs
        self.waits = Waits(arm, since=since)
        self._performers: Mapping[type[Any], Callable[[Any], Answer]] = {
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
        """Carry out an act, wait for its end, and return its answer.

        Raises `Stopped`, what the arm's calls raise, and `kinematics.KinematicsError`.
        """
        # an act that a stop came too late for has ended well, but no further one begins
        self.waits.while_paused()
        return self._performers[type(act)](act)

    def hold(self, text: str) -> None:
        """Wait until a person continues the program. Raises `Stopped`."""
        self.person.hold(text, lambda: self.waits.stopped)
        self.waits.attended()

    @property
    def outputs(self) -> int:
        """The output bits, as far as they are known."""
        known = self.arm.status.outputs
        return self._outputs if known is None else known

    # -- what moves the arm -------------------------------------------------------------------

    def resolved(self, act: Go) -> ProgramMove | None:
        """Return the absolute move of an act; None if it will be refused."""
        parts = self.arm.parts
        try:
            with parts.pace.lock:
                return cast(ProgramMove, resolved(act.move, ground_of(parts, self.arm.points)))
        except (ArmError, KinematicsError):
            return None

    def _go(self, act: Go) -> float | None:
        done = self.arm.start(act.move, stops=self.waits.stops).wait()
        return done.width_mm if isinstance(done, Grasped) else None

    def _home(self, _: Home) -> None:
        if not self.arm.parts.core.position_known:
            self.arm.home()

    # -- what waits ---------------------------------------------------------------------------

    def _delay(self, act: Delay) -> None:
        self.waits.delay(act.time_s)

    def _await_inputs(self, act: AwaitInputs) -> bool:
        try:
            self.arm.io.wait(high=act.high, low=act.low, within_s=act.within_s)
        except InputTimeout:
            if act.within_s is None:  # nothing in simulated time sets the input
                raise
            return False
        return True

    def _hold(self, act: Hold) -> None:
        self.hold(act.text)

    # -- what does neither --------------------------------------------------------------------

    def _switch(self, act: Outputs) -> None:
        core = self.arm.parts.core
        bits = self.outputs & ~output_bits(core, act.off) | output_bits(core, act.on)
        self.arm.io.write(bits)
        self._outputs = bits

    def _read_input(self, act: ReadInput) -> bool:
        bit = input_bits(self.arm.parts.core, act.number)
        return bool(self.arm.io.read() & bit)

    def _look(self, _: Look) -> PlaceValue:
        status = self.arm.status
        return PlaceValue(self.arm.pose, dict(self.arm.joints.deg), status.gripper_mm)

    def _remember(self, act: Remember) -> None:
        self.arm.points[act.name] = Point(joints_of(act.joints_deg, self.arm), act.opening_mm)

    def _say(self, act: Say) -> None:
        self.person.say(act.text)


def joints_of(angles_deg: Mapping[str, float], arm: Arm) -> Joints:
    """Return a posture by the names of the arm's joints. Raises `BadRequest` for other names."""
    names = arm.model.arm.joint_names
    if set(angles_deg) != set(names):
        raise BadRequest(
            f"a place of this arm says {', '.join(names)}, not {', '.join(angles_deg)}"
        )
    return Joints.of(*(angles_deg[name] for name in names), names=names)


# The run of a program: its machine gives acts, and a performer carries them out.


@dataclass(frozen=True, slots=True)
class RunPlan:
    """A program to be run, from its beginning or from where it was interrupted.

    `source` returns a machine at the beginning, for each loop; `loops` is how many there are, or
    `FOR_EVER`. A resumed program is in loop number `loop`, and `machine` returns its machine;
    `left` is the rest of its first move, and `outputs` are the output bits that it had set. With
    `goes_on` more lines follow at a prompt.
    """

    source: Callable[[], Machine]
    loops: int = 1
    loop: int = 1
    machine: Callable[[], Machine] | None = None
    left: ProgramMove | None = None
    outputs: int = 0
    goes_on: bool = False

    @property
    def first(self) -> Callable[[], Machine]:
        """Returns the machine that the run begins with."""
        return self.machine or self.source


# Is called before every act of a run; an exception prevents the act and ends the run.
BeforeAct: TypeAlias = Callable[[RunStep, Machine], object]

# Is called after every act that has ended well, with how long it took on the arm's clock.
AfterAct: TypeAlias = Callable[[RunStep, Answer, float], object]


class ProgramRun:
    """One run of a program. If it fails, `at` is the step that failed."""

    def __init__(
        self,
        plan: RunPlan,
        performer: Performer,
        *,
        before: Sequence[BeforeAct] = (),
        after: Sequence[AfterAct] = (),
    ) -> None:
        self._plan = plan
        self._performer = performer
        self._before = before
        self._after = after
        self.loop = plan.loop
        self.done = 0
        self.at: RunStep | None = None
        self.took_s = 0.0
        self._left = plan.left

    def carry_out(self) -> int:
        """Carry out the rest of the program; return the number of acts."""
        began_s = self._performer.arm.parts.pace.now_s()
        loops, new_machine = self._plan.loops, self._plan.first
        while loops == FOR_EVER or self.loop <= loops:
            machine, new_machine = new_machine(), self._plan.source
            while (stage := machine.next()) is not None:
                self._carry_out(stage, machine)
            if not self._plan.goes_on:
                machine.require_fingers_moved()
            self.loop += 1
        # a stop that came too late for the last act is one all the same
        self._performer.waits.require_no_stop()
        self.at = None
        self.took_s = self._performer.arm.parts.pace.now_s() - began_s
        return self.done

    def _carry_out(self, stage: RunStage, machine: Machine) -> None:
        performer, act = self._performer, stage.act
        performer.waits.require_no_stop()
        left, self._left = self._left, None
        move = None
        if isinstance(act, Go):
            # resolved before others see it: the journal needs goals that stay what they are
            move = left or performer.resolved(act)
            act = act if move is None else replace(act, move=move)
        step = self.at = RunStep(
            performer.arm,
            stage.mark,
            act_name(act),
            self.loop,
            isinstance(act, MOTIONS),
            waiting_text(act),
            act,
            move,
        )
        for notice in self._before:
            notice(step, machine)
        now_s = performer.arm.parts.pace.now_s
        began_s = now_s()
        # without an answer the act is repeated by a resumed program, so it is given only now
        answer = performer.perform(act)
        machine.answer(answer)
        self.done += 1
        took_s = now_s() - began_s
        for learn in self._after:
            learn(step, answer, took_s)
