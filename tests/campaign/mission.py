"""One mission: a program, or several, that use an arm for some seconds while things go wrong.

All of it is drawn from the dialect's name and a seed, so that the same mission comes again.
"""

from __future__ import annotations

import random

from armdrive.errors import LinkError, OutOfBounds, Refused, Stopped
from armdrive.status import State, Trust
from kinematics import KinematicsError, Motors

from .actions import ACTIONS, connect, home, move_certainly
from .clock import CPU_S, Hangs, Killed, cpu_limit
from .faults import FAULTS, NONE, Fault
from .goals import certain_goal, stand_beside_limits
from .laws import Broken, Typed, call, honest, kept
from .outcome import Outcome, Result
from .stage import Stage

FAULT_COUNTS = (0, 1, 1, 1, 1, 1, 2, 2, 3)
TRIES = 4
QUIET_S = 0.6
LONGEST_REST_S = 30.0
UPKEEP = frozenset(
    (
        "connect",
        "reset",
        "enable",
        "home",
        "declare",
        "confirm",
        "reconnect",
        "close",
        "close and connect",
    )
)
"""What a program or an operator does for an arm that is to work: faults strike there as well."""
UPKEEP_FAULTS = 0.08
UPKEEP_S = (0.01, 0.1, 1.0)
"""Within what time of its beginning: some take some hundredths of a second, others many."""


class Mission:
    """A mission under way."""

    cpu_s = CPU_S

    def __init__(self, dialect: str, seed: int) -> None:
        self.dialect, self.seed = dialect, seed
        self.draw = random.Random(f"{dialect} {seed}")
        self.stage = Stage(dialect, self.draw)
        self.outcome = Outcome.ENDED_WELL
        self.happened: list[str] = []
        self.log: list[str] = []
        self._faults_over = False

    def run(self, *, keep_log: bool = False) -> Result:
        """Run it to its end; the log is kept of one that broke a promise."""
        broken: tuple[str, ...] = ()
        try:
            with cpu_limit(self.cpu_s):
                self._run()
        except (Broken, Hangs) as law:
            words = str(law) if isinstance(law, Broken) else f"hangs: {law}"
            self._say(f"BROKEN: {words}")
            self.outcome, broken = Outcome.VIOLATION, (words,)
        return Result(
            self.dialect,
            self.seed,
            self.outcome,
            tuple(dict.fromkeys(self.happened)) or (NONE,),
            broken,
            tuple(self.log) if broken or keep_log else (),
            self.stage.now_s,
        )

    def _run(self) -> None:
        stage, draw = self.stage, self.draw
        if draw.random() < 0.7:  # somebody has used it since it was switched on
            stage.turn_by_hand(Motors(draw.randint(-40, 40) for _ in stage.world.motors))
        if draw.random() < 0.4:
            stand_beside_limits(stage)
        self._act("connect", connect)
        self._mend()
        count = draw.randint(2, 4)
        faults = sorted(
            (draw.randrange(count), draw.random() * draw.choice((0.1, 0.5, 1.5)), self._fault())
            for _ in range(draw.choice(FAULT_COUNTS))
        )
        names, weights = list(ACTIONS), [weight for _, weight in ACTIONS.values()]
        for number in range(count):
            for _, after_s, index in (each for each in faults if each[0] == number):
                self._arrange(FAULTS[index], after_s)
            name = draw.choices(names, weights)[0]
            self._act(name, ACTIONS[name][0])
            if draw.random() < 0.85:
                self._mend()
            elif stage.arm is None:
                self._act("connect", connect)
        self._finale()

    def _fault(self) -> int:
        board = self.stage.twin.board
        return self.draw.choice([i for i, each in enumerate(FAULTS) if each.befalls(board)])

    def _arrange(self, fault: Fault, after_s: float) -> None:
        def happen() -> None:
            if self.stage.alive or not fault.of_programs:
                self.happened.append(fault.name)
                self._say(f"  fault: {fault.name}: {fault.begin(self.stage)}")

        self.stage.agenda.at(self.stage.now_s + after_s, happen)

    # -- doing ----------------------------------------------------------------------------------

    def _act(self, name: str, action) -> Typed | None:
        """Do something; a program that is killed at it is followed by another, later."""
        if self.stage.arm is None and action is not connect:
            return None
        self._say(name)
        if name in UPKEEP and not self._faults_over and self.draw.random() < UPKEEP_FAULTS:
            after_s = self.draw.random() * self.draw.choice(UPKEEP_S)
            self._arrange(FAULTS[self._fault()], after_s)
        try:
            error = action(self.stage)
        except Killed:
            self._say("  the program is no more")
            self._worst(Outcome.PROGRAM_ENDED)
            self.stage.sleep(self.draw.choice((0.02, 0.3, 3.0)))
            kept(self.stage)
            return None
        if error is not None:
            self._say(f"  {type(error).__name__}: {error}")
            self._weigh(error)
        elif self.stage.arm is not None:
            self._say(f"  well; {self.stage.world.motors}")
        return error

    def _weigh(self, error: Typed) -> None:
        if isinstance(error, LinkError):
            self._worst(Outcome.LINK_LOST)
        elif isinstance(error, Refused | KinematicsError | Stopped):
            self._worst(Outcome.REFUSED if not isinstance(error, Stopped) else Outcome.ENDED_WELL)
        else:
            self._worst(Outcome.ERROR_STOP)

    def _worst(self, outcome: Outcome) -> None:
        self.outcome = max(self.outcome, outcome)

    def _say(self, words: str) -> None:
        arm = self.stage.arm
        state = f"{arm.core.state.value}, {arm.core.belief.trust.value}" if arm else "no program"
        self.log.append(f"{self.stage.now_s:9.3f} [{state}] {words}")

    # -- what an operator does ------------------------------------------------------------------

    def _mend(self) -> bool:
        """Bring the arm back to where it can be moved by plans; tell whether it is."""
        stage = self.stage
        for _ in range(TRIES):
            if stage.arm is None and self._act("connect", connect) is not None:
                continue
            if stage.arm is None:
                continue
            status = stage.arm.status
            if status.paused:  # whoever paused it was torn away from it
                self._say("resume")
                stage.arm.resume()
            if status.state is State.DISCONNECTED:
                self._worst(Outcome.LINK_LOST)
                self._again()
            elif status.state is State.ERROR_STOP:
                self._worst(Outcome.ERROR_STOP)
                self._act("reset", lambda stage: call(stage, stage.arm.reset))
            elif status.state is State.DISABLED:
                self._act("enable", lambda stage: call(stage, stage.arm.enable))
            elif status.state is not State.STANDBY:
                self._act("stop", lambda stage: call(stage, stage.arm.stop))
            elif not stage.arm.core.position_known:
                self._refer()
            else:
                return True
        return False

    def _again(self) -> None:
        """Get the wire back: by the same program, or by another one."""
        stage = self.stage
        if self.draw.random() < 0.5:
            self._act("reconnect", lambda stage: call(stage, stage.arm.reconnect))
            return
        self._act("close", lambda stage: call(stage, stage.arm.close))
        stage.leave()
        self._act("connect", connect)

    def _refer(self) -> None:
        """Have somebody look at the arm, once it stands, and say where it is."""
        stage = self.stage
        if stage.arm.status.trust is Trust.RESTORED and self.draw.random() < 0.5:
            self._act("confirm", lambda stage: call(stage, stage.arm.confirm_restored))
            return
        self._act("rest", lambda stage: call(stage, self._stands, None, LONGEST_REST_S + 5.0))
        if stage.arm is None:
            return
        joints, opening_mm = stage.posture()
        if stage.arm.model.arm.violations(joints):  # it has sagged or slipped beyond its limits
            self._act("home", home)
            return
        with stage.watch.referencing() as ended_well:
            stage.watch.referred(faultless=stage.faultless)
            stage.vouched_s = stage.now_s
            error = self._act(
                "declare",
                lambda stage: call(
                    stage, lambda: stage.arm.declare_posture(joints, opening_mm=opening_mm)
                ),
            )
            if error is None and stage.arm is not None:
                ended_well()

    def _stands(self) -> None:
        """Wait until the arm has been seen to stand."""
        stage, before = self.stage, None
        end_s = stage.now_s + LONGEST_REST_S
        while before != stage.look() and stage.now_s < end_s:
            before = stage.look()
            stage.arm.sleep(QUIET_S)

    # -- the end --------------------------------------------------------------------------------

    def _finale(self) -> None:
        """End every fault: then the arm comes back, and works as before."""
        stage = self.stage
        self._faults_over = True
        stage.watch.untold(stage.now_s)
        stage.agenda.clear()
        stage.twin.faults.end()
        stage.untold_until_s.clear()
        stage.disk.full = False
        stage.disk.ends_in = stage.link.ends_in = None
        stage.link.line.faults.lose_late()
        self._say("all faults are over")
        if stage.arm is not None:
            self._act("rest", lambda stage: call(stage, lambda: stage.arm.sleep(5.0)))
            honest(stage, strict=stage.arm.core.state is State.STANDBY)
        for _ in range(3):
            if self._mend() and self._works():
                break
        else:
            raise Broken("the arm could not be brought back")
        self._act("close", lambda stage: call(stage, stage.arm.close))

    def _works(self) -> bool:
        """Move to where nothing forbids it; the physical arm arrives, which `call` checks."""
        stage = self.stage
        if stage.watch.slips:  # nobody has noticed but the person who looks
            self._refer()
        goal = certain_goal(stage)
        if goal is None:  # it stands inside a guard, or where every way leads deeper into one
            self._act("home", home)
            goal = certain_goal(stage)
        if goal is None or stage.arm is None or not stage.arm.core.position_known:
            return False
        before = stage.look()
        error = self._act("last move_j", lambda stage: move_certainly(stage, goal))
        if isinstance(error, OutOfBounds | KinematicsError):
            raise Broken(f"a motion that nothing forbids was refused: {error}")
        if error is not None or stage.arm.core.state is not State.STANDBY:
            return False
        if not (stage.look() - before).largest:
            raise Broken("the arm was brought back, and its motors do not turn")
        return True


def run_mission(dialect: str, seed: int, *, keep_log: bool = False) -> Result:
    """Run one mission."""
    return Mission(dialect, seed).run(keep_log=keep_log)
