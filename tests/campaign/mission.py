"""One mission: one program or several use an arm for some seconds, and things go wrong.

The dialect's name and a seed determine the whole mission, so that it can be repeated.
"""

import random
from dataclasses import dataclass
from enum import IntEnum

from armdrive.errors import LinkError, OutOfBounds, Refused, Stopped
from armdrive.status import State, Trust
from kinematics import KinematicsError, Motors
from tests.conformance.observation import Broken, check
from tests.scenarios.actions import (
    ACTIONS,
    HOMING_ACTIONS,
    HOMING_S,
    Action,
    connect,
    home,
    move_to_joints,
)
from tests.scenarios.goals import certain_goal, place_near_limits
from tests.scenarios.happenings import HAPPENINGS
from tests.scenarios.laws import TypedError, call, check_trust
from tests.scenarios.program import CPU_S, Hang, ProgramKilled, cpu_limit

from .arms import an_arm
from .programs import PROGRAM_FAULTS

FAULT_COUNTS = (0, 1, 1, 1, 1, 1, 2, 2, 3)
TRIES = 4
STILL_S = 0.6
LONGEST_REST_S = 30.0
RECOVERY_FAULT_SHARE = 0.08
"""The share of the actions that bring an arm back that something disturbs."""
RECOVERY_FAULT_WITHIN_S = (0.01, 0.1, 1.0)
"""How soon after the start of the action: some take hundredths of a second, others many seconds."""


class Outcome(IntEnum):
    """The worst event of a mission. The arm was brought back after all but a violation."""

    ENDED_WELL = 0
    REFUSED = 1
    ERROR_STOP = 2
    PROGRAM_ENDED = 3
    LINK_LOST = 4
    VIOLATION = 5


@dataclass(frozen=True, slots=True)
class Result:
    """The result of one mission; `broken` has a sentence for each law that it broke."""

    dialect: str
    seed: int
    outcome: Outcome
    faults: tuple[str, ...]
    broken: tuple[str, ...] = ()
    log: tuple[str, ...] = ()
    simulated_s: float = 0.0

    @property
    def command(self) -> str:
        """The command that repeats the mission."""
        return f"python -m tests.campaign --dialect {self.dialect} --only {self.seed}"


class Mission:
    """A mission under way."""

    cpu_s = CPU_S

    def __init__(self, dialect: str, seed: int) -> None:
        self.dialect, self.seed = dialect, seed
        self.draw = random.Random(f"{dialect} {seed}")
        self.stage = an_arm(dialect, self.draw)
        self.homes = self.stage.config.homing is not None
        self.outcome = Outcome.ENDED_WELL
        self.happened: list[str] = []
        self.log: list[str] = []
        self._faults_over = False
        self._found_at = self.stage.posture()
        board = self.stage.twin.board
        self._faults = {each.name: each for each in HAPPENINGS if isinstance(board, each.needs)}

    def run(self, *, keep_log: bool = False) -> Result:
        """Run the mission; keep its log if asked to, or if a law was broken."""
        broken: tuple[str, ...] = ()
        try:
            with cpu_limit(self.cpu_s):
                self._run()
        except (Broken, Hang) as law:
            words = str(law) if isinstance(law, Broken) else f"hangs: {law}"
            self._note(f"BROKEN: {words}")
            self.outcome, broken = Outcome.VIOLATION, (words,)
        return Result(
            self.dialect,
            self.seed,
            self.outcome,
            tuple(dict.fromkeys(self.happened)),
            broken,
            tuple(self.log) if broken or keep_log else (),
            self.stage.now_s,
        )

    def _run(self) -> None:
        stage, draw = self.stage, self.draw
        if draw.random() < 0.7:  # the registers of an arm that was used are not zero
            stage.turn_by_hand(Motors(draw.randint(-40, 40) for _ in stage.world.motors))
        if draw.random() < 0.4:
            place_near_limits(stage, draw)
        self._act("connect", connect)
        self._recover()
        count = draw.randint(2, 4)
        struck = [draw.randrange(count) for _ in range(draw.choice(FAULT_COUNTS))]
        actions = {**ACTIONS, **HOMING_ACTIONS} if self.homes else ACTIONS
        names, weights = list(actions), [weight for _, weight in actions.values()]
        for number in range(count):
            name = draw.choices(names, weights)[0]
            longer = HOMING_S if self.homes and name in HOMING_ACTIONS else 1.0
            for _ in range(struck.count(number)):
                self._schedule_fault(draw.random() * draw.choice((0.1, 0.5, 1.5)) * longer)
            self._act(name, actions[name][0])
            if draw.random() < 0.85:
                self._recover()
            elif stage.arm is None:
                self._act("connect", connect)
        self._finish()

    def fault(self) -> str:
        """Draw something that can happen to this arm."""
        return self.draw.choice([*self._faults, *PROGRAM_FAULTS])

    def _schedule_fault(self, after_s: float) -> None:
        name = self.fault()

        def happen() -> None:
            if name in self._faults:
                words = self.stage.strike(self._faults[name], self.draw)
            elif self.stage.pace.dead or not (self.stage.arm or self.stage.referencing):
                return
            else:
                words = PROGRAM_FAULTS[name](self.stage, self.draw)
            self.happened.append(name)
            self._note(f"  {name}: {words}")

        self.stage.timeline.at(self.stage.now_s + after_s, happen)

    # -- doing ----------------------------------------------------------------------------------

    def _act(self, name: str, action: Action) -> TypedError | None:
        """Run an action; return its error. If the program is killed, another one follows later."""
        if self.stage.arm is None and action is not connect:
            return None
        self._note(name)
        try:
            error = action(self.stage, self.draw)
        except ProgramKilled:
            self._note("  the program is no more")
            self._worsen(Outcome.PROGRAM_ENDED)
            self.stage.sleep(self.draw.choice((0.02, 0.3, 3.0)))
            check_trust(self.stage)
            return None
        if error is not None:
            self._note(f"  {type(error).__name__}: {error}")
            self._count_error(error)
        elif self.stage.arm is not None:
            self._note(f"  well; {self.stage.world.motors}")
        return error

    def _bring_back(self, name: str, act: str) -> TypedError | None:
        """Make a call that brings the arm back, which may be disturbed as well."""
        if not self._faults_over and self.draw.random() < RECOVERY_FAULT_SHARE:
            self._schedule_fault(self.draw.random() * self.draw.choice(RECOVERY_FAULT_WITHIN_S))
        return self._act(
            name, lambda stage, _: call(stage, getattr(stage.arm, act), references=True)
        )

    def _count_error(self, error: TypedError) -> None:
        if isinstance(error, LinkError):
            self._worsen(Outcome.LINK_LOST)
        elif isinstance(error, Refused | KinematicsError):
            self._worsen(Outcome.REFUSED)
        elif not isinstance(error, Stopped):
            self._worsen(Outcome.ERROR_STOP)

    def _worsen(self, outcome: Outcome) -> None:
        self.outcome = max(self.outcome, outcome)

    def _note(self, words: str) -> None:
        arm = self.stage.arm
        core = arm.parts.core if arm is not None else None
        state = f"{core.state.value}, {core.belief.trust.value}" if core else "no program"
        self.log.append(f"{self.stage.now_s:9.3f} [{state}] {words}")

    # -- what an operator does ------------------------------------------------------------------

    def _recover(self) -> bool:
        """Bring the arm to where planned motion is possible; return whether that succeeded."""
        stage = self.stage
        for _ in range(TRIES):
            if stage.arm is None:
                self._act("connect", connect)
                continue
            status = stage.arm.status
            if status.paused:  # a fault ended the action that had paused it
                self._note("resume")
                stage.arm.resume()
            if status.state is State.DISCONNECTED:
                self._worsen(Outcome.LINK_LOST)
                self._reconnect()
            elif status.state is State.ERROR_STOP:
                self._worsen(Outcome.ERROR_STOP)
                self._bring_back("reset", "reset")
            elif status.state is State.DISABLED:
                self._bring_back("enable", "enable")
            elif status.state is not State.STANDBY:
                self._bring_back("stop", "stop")
            elif not stage.arm.parts.core.position_known:
                self._reference()
            else:
                return True
        return False

    def _reconnect(self) -> None:
        """Connect again: with the same program, or with another one."""
        if self.draw.random() < 0.5:
            self._bring_back("reconnect", "reconnect")
            return
        self._bring_back("close", "close")
        self.stage.program_ended()
        self._act("connect", connect)

    def _reference(self) -> None:
        """Reference the arm once it stands: confirm, declare its posture, or home."""
        stage, arm = self.stage, self.stage.arm
        assert arm is not None
        if arm.status.trust is Trust.RESTORED and self.draw.random() < 0.5:
            self._act(
                "confirm",
                lambda stage, _: call(stage, arm.reference.confirm_restored, references=True),
            )
            return
        self._act(
            "rest",
            lambda stage, _: call(stage, self._wait_until_still, None, LONGEST_REST_S + 5.0),
        )
        if stage.arm is None:
            return
        joints, opening_mm = stage.posture()
        if stage.arm.model.arm.violations(joints):  # the arm sagged or slipped beyond a limit
            self._bring_inside()
            return
        self._act(
            "declare",
            lambda stage, _: call(
                stage,
                lambda: arm.reference.declare(joints, opening_mm=opening_mm),
                references=True,
            ),
        )

    def _bring_inside(self) -> None:
        """Home; if the switches do not help, a person brings the arm to where it was found."""
        stage = self.stage
        error, device = self._act("home", home), stage.twin.device
        if error is not None and self.homes and device.powered and not device.moving:
            self._note("  brought back by hand")
            stage.place_by_hand(*self._found_at)

    def _wait_until_still(self) -> None:
        """Wait until the physical arm stands."""
        stage, before = self.stage, None
        end_s = stage.now_s + LONGEST_REST_S
        while before != stage.look() and stage.now_s < end_s:
            before = stage.look()
            stage.sleep(STILL_S)

    # -- the end --------------------------------------------------------------------------------

    def _finish(self) -> None:
        """End every fault, and check that the arm can be brought back and moves."""
        stage = self.stage
        self._faults_over = True
        stage.timeline.clear()
        stage.twin.faults.end()
        stage.disk.full = False
        stage.disk.kill_after = stage.link.kill_after = None
        stage.link.line.faults.lose_late()
        self._note("all faults are over")
        if stage.arm is not None:
            self._act("rest", lambda stage, _: call(stage, lambda: stage.sleep(5.0)))
            check_trust(stage, strict=stage.arm.parts.core.state is State.STANDBY)
        for _ in range(3):
            if self._recover() and self._moves_again():
                break
        else:
            raise Broken("the arm could not be brought back")
        self._bring_back("close", "close")

    def _moves_again(self) -> bool:
        """Move to a goal that the driver must allow; return whether the arm went there.

        `call` checks that the physical arm has arrived. A refusal breaks a law.
        """
        stage = self.stage
        assert stage.arm is not None
        if stage.watch.hidden or not stage.is_true():  # only the person at the arm can see that
            self._reference()
        goal = certain_goal(stage, self.draw)
        if goal is None:  # the arm is inside a guard, or every path leads deeper into one
            self._bring_inside()
            goal = certain_goal(stage, self.draw)
        if goal is None or stage.arm is None or not stage.arm.parts.core.position_known:
            return False
        before = stage.look()
        error = self._act("last move_j", lambda stage, _: move_to_joints(stage, goal))
        if isinstance(error, OutOfBounds | KinematicsError):
            raise Broken(f"a motion that nothing forbids was refused: {error}")
        if error is not None or stage.arm.parts.core.state is not State.STANDBY:
            return False
        moved = (stage.look() - before).largest
        check(moved > 0, "the arm was brought back, and its motors do not turn")
        return True


def run_mission(dialect: str, seed: int, *, keep_log: bool = False) -> Result:
    """Run one mission."""
    return Mission(dialect, seed).run(keep_log=keep_log)


def run_task(task: tuple[str, int]) -> Result:
    """Run the mission of a dialect and a seed."""
    return run_mission(*task)
