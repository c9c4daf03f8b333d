"""A sample of the campaign on any bench: short missions with faults.

The laws are those of `tests.campaign`: a trusted position is where the physical arm stands, a call
succeeds or raises a typed error, and the arm works again once the faults are over. The dialect's
name and a seed determine a mission's actions and faults, but not their exact timing.
"""

import random
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.arm import Arm
from armdrive.errors import ArmError
from armdrive.moves import Jog
from armdrive.status import State, Trust
from kinematics import KinematicsError, LinePart
from tests.conformance.bench import Bench
from tests.conformance.faults import FAULTS, Fault
from tests.conformance.motions import begin_sweep, joints_from, shifted
from tests.conformance.observation import ON_THE_STEP, Broken
from tests.conformance.rows_faults import bring_back, check_moves, inject

FAULTY = 0.75
"""The share of actions that a fault disturbs."""
LATEST_S = 1.2
"""The longest time from the start of an action to its fault."""
NOTICED_S = 3.0
"""An idle driver polls its device at least twice within this time."""
TRUSTED = (Trust.REFERENCED, Trust.RESTORED)
SPEEDS = (0.1, 0.3, 0.6, 1.0)
ACTIONS_EACH = (2, 4)


@dataclass(frozen=True, slots=True)
class MissionResult:
    """The outcome of a mission; `broken` is the promise that was not kept, empty if none."""

    seed: int
    faults: tuple[str, ...]
    broken: str
    log: tuple[str, ...]


Action = Callable[[Arm, random.Random], object]


def _move_j(arm: Arm, draw: random.Random) -> object:
    goal = joints_from(arm, draw.uniform(-20.0, 20.0), draw.uniform(-8.0, 8.0))
    return arm.move_j(speed=draw.choice(SPEEDS), **goal)


def _move_l(arm: Arm, draw: random.Random) -> object:
    goal = shifted(arm.pose, *(draw.uniform(-12.0, 12.0) for _ in range(3)))
    return arm.move_l(goal, speed=draw.choice(SPEEDS))


def _path(arm: Arm, draw: random.Random) -> object:
    corner = shifted(arm.pose, y_mm=draw.choice((-20.0, 20.0)))
    end = shifted(corner, z_mm=draw.choice((-15.0, 15.0)))
    return arm.move_path([LinePart(corner, 5.0), LinePart(end)], speed=draw.choice(SPEEDS))


def _jog(arm: Arm, draw: random.Random) -> object:
    name = draw.choice(arm.model.arm.joint_names)
    return arm.jog_j(**{f"{name}_deg": draw.uniform(-2.0, 2.0)})


def _hold(arm: Arm, draw: random.Random) -> object:
    name = draw.choice(arm.model.arm.joint_names)
    arm.jogging.hold(
        Jog.joint(**{name: draw.choice((-1.0, 1.0))}), speed=draw.choice(SPEEDS), for_s=0.8
    )
    arm.sleep(draw.uniform(0.1, 0.7))
    arm.jogging.release()
    return arm.sleep(1.0)


def _stop(arm: Arm, draw: random.Random) -> object:
    begin_sweep(arm, draw.choice((-30.0, 30.0)), draw.choice(SPEEDS))
    arm.sleep(draw.uniform(0.0, 0.8))
    return arm.stop()


def _pause(arm: Arm, draw: random.Random) -> object:
    handle = begin_sweep(arm, draw.choice((-10.0, 10.0)))
    arm.sleep(draw.uniform(0.1, 0.4))
    arm.pause()
    arm.sleep(1.0)
    arm.resume()
    return handle.wait()


def _rest(arm: Arm, draw: random.Random) -> object:
    return arm.sleep(draw.choice((0.5, 1.5)))


ACTIONS: Mapping[str, tuple[Action, int]] = MappingProxyType(
    {
        "move_j": (_move_j, 5),
        "move_l": (_move_l, 3),
        "move_path": (_path, 2),
        "jog": (_jog, 2),
        "hold and release": (_hold, 2),
        "stop": (_stop, 2),
        "pause and resume": (_pause, 2),
        "rest": (_rest, 1),
    }
)
"""Every action with its weight."""


class FirmwareMission:
    """One mission on a bench that was made for it."""

    def __init__(self, bench: Bench, seed: int) -> None:
        self._bench, self._seed = bench, seed
        self._draw = random.Random(f"{bench.row.name} {seed}")
        self._faults: list[str] = []
        self._log: list[str] = []
        self._slipped = False
        """Whether a motor may have slipped since the last reference: no stepper reports that."""

    def run(self) -> MissionResult:
        """Run the mission to its end."""
        broken = ""
        try:
            self._run()
        except Broken as law:
            broken = str(law)
        except (ArmError, KinematicsError) as error:
            broken = f"the arm could not be brought back: {type(error).__name__}: {error}"
        except Exception:
            broken = f"a traceback: {traceback.format_exc(limit=-4)}"
        if broken:
            self._log.append(f"BROKEN: {broken}")
        return MissionResult(self._seed, tuple(self._faults), broken, tuple(self._log))

    def _run(self) -> None:
        bench, draw = self._bench, self._draw
        arm = bench.ready()
        arm.move_j(**joints_from(arm, 3.0, -2.0))  # so that a reset, which zeroes the counts, shows
        possible = [each for each in FAULTS if not any(rule(bench) for rule in each.needs)]
        names, weights = list(ACTIONS), [weight for _, weight in ACTIONS.values()]
        for _ in range(draw.randint(*ACTIONS_EACH)):
            name = draw.choices(names, weights)[0]
            fault = draw.choice(possible) if draw.random() < FAULTY else None
            after_s = draw.uniform(0.0, LATEST_S)
            self._act(arm, name, fault, after_s)
            arm = self._bring_back(arm, spoiled=fault is not None and fault.misdirects(bench))

    def _act(self, arm: Arm, name: str, fault: Fault | None, after_s: float) -> None:
        bench = self._bench
        if fault is not None:
            inject(bench, fault, after_s)
            self._faults.append(fault.name)
            self._slipped = self._slipped or not fault.evident
            self._log.append(f"after {after_s:.2f} s: {fault.name}")
        try:
            ACTIONS[name][0](arm, self._draw)
            self._log.append(f"{name}: well; {bench.look().motors}")
        except (ArmError, KinematicsError) as error:
            self._log.append(f"{name}: {type(error).__name__}: {error}")
        bench.rest()
        if fault is not None:
            bench.sleep(NOTICED_S)
        bench.heal()
        self._check_trust(arm)

    def _check_trust(self, arm: Arm) -> None:
        """Check that a trusted position is where the motors stand."""
        status, seen = arm.status, self._bench.look()
        if self._slipped or status.trust not in TRUSTED or status.acknowledged is None:
            return
        if status.state is State.DISCONNECTED:
            return
        if seen.off_steps(status.acknowledged) > ON_THE_STEP:
            raise Broken(
                f"{status.trust.value} ({status.trust_reason}) at {tuple(status.acknowledged)}, "
                f"but the motors stand at {tuple(seen.motors)}"
            )

    def _bring_back(self, arm: Arm, *, spoiled: bool) -> Arm:
        """Reset and reference the arm, and check that it moves."""
        bench = self._bench
        arm = self._reference(arm)
        try:
            check_moves(bench, arm)
        except ArmError:
            if not spoiled:
                raise
            # a damaged line in the device's buffer may spoil the first motion after a fault
            arm = self._reference(arm)
            check_moves(bench, arm)
        return arm

    def _reference(self, arm: Arm) -> Arm:
        bench = self._bench
        state, trust = arm.status.state, arm.status.trust
        arm = bring_back(bench, arm)
        if state is not State.STANDBY or trust is not Trust.REFERENCED or self._slipped:
            bench.reference(arm)
            self._slipped = False
            self._log.append("brought back and referenced")
        return arm
