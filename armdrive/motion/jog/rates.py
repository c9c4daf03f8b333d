"""How fast a jog goes at the moment, and how it gets to what is wished for: by its ramp.

Speeds are shares of full speed, one for each axis of a space. Where a device queues what it is
sent, speed carries on from leg to leg. Elsewhere the arm stands between two bursts, so that a
change of direction begins anew, and the ramp is no longer than the first burst: that one goes at
half the speed, which is felt, and the others at all of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.motion.jog.bounds import JogPath, Kind
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import CARTESIAN_AXES, GRIPPER_AXIS, YAW_AXIS, Space
from armdrive.runtime.position import ArmCoordinates
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.rates import Rates, joint_rates, ramped, share_of_limits

STALE_S = 1.0
"""An arm whose last leg should have ended so long ago stands: no exchange takes longer."""


@dataclass(frozen=True, slots=True)
class RateGoal:
    """What can be had of a wish: shares of full speed, of the `speed` that was wished for.

    `had` is the share of the wish that joints and motors can do.
    """

    shares: Rates
    speed: float
    had: float = 1.0

    @property
    def most(self) -> float:
        """The greatest share."""
        return max(map(abs, self.shares))


@dataclass(frozen=True, slots=True)
class Paced:
    """The speed of one leg: its mean, and what it ends with.

    `ramp_s` is how long it takes to lose the mean speed; each axis alone takes its part of that.
    """

    kind: Kind
    mean: Rates
    end: Rates
    slope: float

    @property
    def ramp_s(self) -> float:
        """How long it takes to lose the mean speed."""
        return max(map(abs, self.mean)) / self.slope if self.slope > 0.0 else 0.0

    def slowed(self, shares: tuple[float, ...]) -> Paced:
        """Return the speed with some axes slowed; an axis that is does not end faster."""
        mean = tuple(a * share for a, share in zip(self.mean, shares, strict=True))
        end = tuple(
            b if share >= 1.0 else a for a, b, share in zip(mean, self.end, shares, strict=True)
        )
        return Paced(self.kind, mean, end, self.slope)


class Pacer:
    """The speed of one jog. `ramp_s` is from rest to full speed."""

    def __init__(self, ramp_s: float, *, carries: bool) -> None:
        self._ramp_s = ramp_s
        self._carries = carries
        self._last: Paced | None = None
        self._until_s = -math.inf

    def kind(self, wished: Kind, now_s: float) -> Kind:
        """Return the space and frame to move in now: a moving arm first ends what it is in."""
        last = self._moving(now_s)
        return last.kind if last is not None and self._carries else wished

    def paced(self, kind: Kind, goal: RateGoal, time_s: float, now_s: float) -> Paced:
        """Return the speed of a leg on the way to a goal."""
        last = self._moving(now_s)
        most = goal.most
        if last is None or last.kind != kind:
            now = (0.0,) * len(goal.shares)
        else:
            now = last.end if self._carries else _along(goal, last.end)
            fastest = max(map(abs, now))
            if goal.had < 1.0 and fastest > most:  # joints or motors cannot do more here
                now = tuple(each * most / fastest for each in now)
        slope = (
            last.slope if last is not None and not most else self._slope(most / goal.speed, time_s)
        )
        return Paced(kind, *ramped(now, goal.shares, slope, time_s), slope)

    def stand(self) -> None:
        """Hear that the arm stands."""
        self._last = None

    def taken(self, paced: Paced, time_s: float, now_s: float) -> None:
        """Hear that a leg is driven now, or behind the one before."""
        self._last = paced
        self._until_s = max(self._until_s, now_s) + time_s if self._carries else now_s + time_s

    def _slope(self, share: float, time_s: float) -> float:
        ramp_s = self._ramp_s if self._carries else min(self._ramp_s, time_s)
        return share / ramp_s if ramp_s > 0.0 else math.inf

    def _moving(self, now_s: float) -> Paced | None:
        """Return the speed of an arm that moves, or has just ended a burst."""
        last = self._last
        if last is None or not any(last.end) or now_s > self._until_s + STALE_S:
            return None
        return last


def _along(goal: RateGoal, before: Rates) -> Rates:
    """Return as much of a goal as there was of speed, if it led about the same way."""
    together = sum(a * b for a, b in zip(goal.shares, before, strict=True))
    if not goal.most or together <= 0.0:
        return (0.0,) * len(goal.shares)
    share = min(max(map(abs, before)) / goal.most, 1.0)
    return tuple(each * share for each in goal.shares)


# How much of a wished jog joints and motors can do from where the arm is, all axes slowed alike.
#
# Near a singularity a line of the tip asks more and more of the joints. What a leg asks is measured
# by solving it; of the five-axis build its joint rates are the first guess.

ANGULAR_JOG_RAD_S = math.radians(45.0)
"""Pitch, roll and yaw of a Cartesian jog at full speed, before the joints' limits slow it."""

TRIES = 12
NEARLY = 0.93
"""A leg that needs this share of its time, or all of it, is as fast as can be."""
EXACTLY = 1.0 + 1e-9
LEAST, MOST = 0.05, 4.0
"""By what factor a guess is corrected at once."""


def axis_names(config: ArmConfig, space: Space) -> tuple[str, ...]:
    """Return the axes of a jog in a space, the gripper last."""
    if space is Space.JOINT:
        return (*config.model.arm.joint_names, GRIPPER_AXIS)
    yaw = (YAW_AXIS,) if config.model.arm.has_yaw else ()
    return (*CARTESIAN_AXES, *yaw, GRIPPER_AXIS)


class Scale:
    """Full speeds of the axes, and what can be had of them."""

    def __init__(self, config: ArmConfig, speeds: SpeedLimits) -> None:
        self._arm = config.model.arm
        self._speeds = speeds
        yaw = (ANGULAR_JOG_RAD_S,) * self._arm.has_yaw
        tip = (config.motion.tip_speed_mm_s,) * 3
        self._full: dict[Space, Rates] = {
            Space.JOINT: (*speeds.joints_rad_s, speeds.gripper_mm_s),
            Space.CARTESIAN: (
                *tip,
                ANGULAR_JOG_RAD_S,
                ANGULAR_JOG_RAD_S,
                *yaw,
                speeds.gripper_mm_s,
            ),
        }

    def full(self, space: Space) -> Rates:
        """Return full speed in rad/s and mm/s."""
        return self._full[space]

    def first_guess(self, start: ArmCoordinates, rates: Sequence[float], speed: float) -> float:
        """Return what the joint rates alone allow of a tip's rates, 1 where nobody knows."""
        if not isinstance(self._arm, FiveAxisArm):
            return 1.0
        angles = start.joints.angles_rad
        found = joint_rates(angles, rates[:-1], self._arm.lengths)  # type: ignore[arg-type]
        if found is None:
            return 1.0
        return share_of_limits(found, [limit * speed for limit in self._speeds.joints_rad_s])

    def share(
        self,
        way: JogPath,
        start: ArmCoordinates,
        time_s: float,
        speed: float,
        guess: float,
    ) -> float:
        """Return the share of a way's speed with which a leg of `time_s` keeps all limits.

        Limits are those of `speed`. Where nothing but a little can be solved, a little is given.
        """
        share = guess
        known = 0.0
        for _ in range(TRIES):
            there = way.at(time_s * share)
            if there is None:
                share = max(share / 2.0, known)
                if share == known:
                    break
                continue
            need_s = self._speeds.duration_s(start, there, speed)
            if need_s <= time_s * EXACTLY:
                known = max(known, share)
                if share >= 1.0 or need_s >= NEARLY * time_s:
                    break
            share *= min(max(0.97 * time_s / need_s if need_s else MOST, LEAST), MOST)
            share = min(share, 1.0)
        return known or share
