"""Jogging simulated arms at full speed into whatever bounds them, and out of it again.

What is measured is the physical arm: how far beyond a limit or a guard it ever was, how far before
the bound it came to rest, and how long it took to move back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from jog_ground import Stand

from armdrive import Jog
from armdrive.moves import Space
from armdrive.status import State
from kinematics import Joints

LOOK_S = 0.02
STANDS_S = 0.5
"""Motors that have not moved for so long stand; between two bursts they do for less."""

LONGEST_S = 20.0
BACK_S = 0.8
HELD_S = 0.25
AT_LIMIT_RAD = 0.005

AT_REST_STEPS = 1.0
MOVING_STEPS = 1.5
"""Rounding is half a step, and motors that move are not all at the same one."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """One trial. A step is one of every motor that turns a joint, or that moves the tip.

    `left_steps` is how far before the bound the arm stood, None where it did not come to one.
    `over_steps` is the furthest it ever was beyond, `rest_steps` where it stood; `back_s` is how
    long the way back took to begin, and `stall_s` the longest stand-still soon after that.
    """

    what: str
    ended: str
    state: State
    left_steps: float | None
    over_steps: float
    rest_steps: float
    back_s: float
    stall_s: float

    @property
    def kept(self) -> bool:
        """Whether no limit was passed by more than a step, and nothing went into error-stop."""
        passed = self.rest_steps > AT_REST_STEPS or self.over_steps > MOVING_STEPS
        return not passed and self.state is not State.ERROR_STOP


class Ground(Stand):
    """One simulated arm, jogged from one posture after the other."""

    def __init__(self, dialect: str, seed: int, *, over_base: bool = False) -> None:
        super().__init__(dialect, seed, over_base=over_base)
        self.stand(Joints.of(0.0, 60.0, -80.0, -30.0, 0.0), 30.0)
        before = self.twin.world.joints[0]
        self.begins_s, self.stands_s = self.held_s(Jog.joint(base=1.0))
        turned = self.twin.world.joints[0] - before
        full = self.config.model.joint_speeds_rad_s[0] * (BACK_S - self.begins_s)
        self.share = turned / full

    def outcome(self, what: str, jog: Jog, joints: Joints, opening_mm: float) -> Outcome:
        """Hold a jog until the arm stands, then hold its reverse."""
        self.stand(joints, opening_mm)
        over, stands = self._held_to_its_end(jog)
        status, world = self.arm.status, self.twin.world
        rest = self.probe.over_steps(world.joints)
        left = self.probe.left_steps(jog, world.joints, world.opening_mm) if stands else None
        back_s, stall_s = self.held_s(self._back(jog))
        over = max(over, self.probe.over_steps(world.joints))
        state = self.arm.status.state
        self.arm.release()
        self.arm.sleep(STANDS_S)
        if state is State.ERROR_STOP:
            self.arm.reset()
        return Outcome(what, status.notice, state, left, over, rest, back_s, stall_s)

    def _held_to_its_end(self, jog: Jog) -> tuple[float, bool]:
        """Return how far the arm was beyond a bound at most, and whether it came to rest."""
        arm, world, over = self.arm, self.twin.world, 0.0
        began_s = moved_s = arm.status.time_s
        last = world.motors
        while (now_s := arm.status.time_s) < moved_s + STANDS_S and now_s < began_s + LONGEST_S:
            arm.hold(jog, speed=1.0, for_s=HELD_S)
            arm.sleep(LOOK_S)
            if world.motors != last:
                last, moved_s = world.motors, now_s
                over = max(over, self.probe.over_steps(world.joints))
        return over, now_s >= moved_s + STANDS_S

    def held_s(self, jog: Jog) -> tuple[float, float]:
        """Hold a jog for a while; return when motors first moved, and how long they then stood."""
        arm, world = self.arm, self.twin.world
        began_s = moved_s = arm.status.time_s
        last, first_s, stall_s = world.motors, math.inf, 0.0
        while arm.status.time_s < began_s + BACK_S:
            arm.hold(jog, speed=1.0, for_s=HELD_S)
            arm.sleep(LOOK_S / 2.0)
            now_s = arm.status.time_s
            if world.motors != last:
                last, first_s = world.motors, min(first_s, now_s - began_s)
                stall_s = max(stall_s, now_s - moved_s) if moved_s > began_s else 0.0
                moved_s = now_s
        arm.release()
        return first_s, stall_s

    def _back(self, jog: Jog) -> Jog:
        """Return the jog that leads back the way it came: without joints that had ended before."""
        axes = [(name, -amount) for name, amount in jog.axes]
        if jog.space is Space.JOINT:
            here = self.twin.world.joints
            ended = [
                name
                for name, bounds in zip(here.names, self.probe.geometry.limits, strict=True)
                if min(here[name] - bounds.low_rad, bounds.high_rad - here[name]) < AT_LIMIT_RAD
            ]
            axes = [axis for axis in axes if axis[0] not in ended] or axes
        return replace(jog, axes=tuple(axes))


def trials(dialect: str, seed: int, count: int) -> Iterator[Outcome]:
    """Jog an arm into limits, guards and past the singularity over its base, in turn."""
    ground, over_base = Ground(dialect, seed), None
    for number in range(count):
        if number % 10 == 9:
            over_base = over_base or Ground(dialect, seed, over_base=True)
            yield over_base.outcome(*over_base.over_base())
        elif number % 2:
            yield ground.outcome(*ground.into_limit())
        else:
            yield ground.outcome(*ground.into_guard())
