"""The speed of a jog: its ramp, and the speeds that joints and motors can reach.

Speeds are shares of full speed, one for each axis of a space. On a device with a queue, the speed
carries over from leg to leg. Otherwise the arm stands between two bursts: a change of direction
starts from rest, and the ramp is no longer than the first burst, which runs at half the speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import add, sub

from armdrive.config.arm import ArmConfig
from armdrive.motion.jog.bounds import JogPath, Kind
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import CARTESIAN_AXES, GRIPPER_AXIS, YAW_AXIS, Space
from armdrive.runtime.position import ArmCoordinates

# --- ramps and braking ---------------------------------------------------------------------------
#
# Rates are speeds of axes, in any unit, or shares of full speed. This code runs many times a
# second, so it uses plain floats and tuples and checks nothing.

Rates = tuple[float, ...]


def ramped(now: Rates, wish: Rates, slope: float, time_s: float) -> tuple[Rates, Rates]:
    """Return the mean and the final rates of a ramp of `time_s` from `now` towards `wish`.

    All rates change in proportion, and the one with the greatest change by `slope` a second. So a
    line that starts from rest is straight, and a change of direction passes through zero.
    """
    gaps = list(map(sub, wish, now))
    gap = max(*gaps, -min(gaps))
    if gap == 0.0 or slope == math.inf:
        return wish, wish
    share = slope * time_s / gap
    if share >= 1.0:
        return _towards(wish, -0.5 / share, gaps), wish
    return _towards(now, 0.5 * share, gaps), _towards(now, share, gaps)


def _towards(place: Rates, share: float, gaps: Sequence[float]) -> Rates:
    return tuple(map(add, place, map(share.__mul__, gaps)))


def braking_share(way_s: float, time_s: float, ramp_s: float) -> float:
    """Return the share of a speed that may be kept for `time_s` without passing a bound.

    At the full speed the bound is `way_s` away, and braking to rest takes `ramp_s`. A share s
    covers s * time_s and brakes over s^2 * ramp_s / 2; the result solves for their sum, way_s.
    """
    if way_s <= 0.0:
        return 0.0
    share = 2.0 * way_s / (time_s + math.sqrt(time_s * time_s + 2.0 * ramp_s * way_s))
    return min(share, 1.0)


def shares_to_stop(
    places: Sequence[float],
    rates: Sequence[float],
    spans: Sequence[tuple[float, float]],
    time_s: float,
    ramps_s: Sequence[float],
) -> list[float]:
    """Return the share of its rate at which each axis still stops within its span.

    `ramps_s` is the time that each axis needs to brake to rest. The least share, applied to all
    axes, keeps the tip on its line.
    """
    shares = []
    for place, rate, (low, high), ramp_s in zip(places, rates, spans, ramps_s, strict=True):
        if rate == 0.0:
            shares.append(1.0)
            continue
        way_s = ((high if rate > 0.0 else low) - place) / rate
        shares.append(1.0 if way_s > time_s + ramp_s else braking_share(way_s, time_s, ramp_s))
    return shares


# --- the speeds that an arm can reach ------------------------------------------------------------

STALE_S = 1.0  # an arm whose latest leg ended this long ago is at rest: no exchange takes longer


@dataclass(frozen=True, slots=True)
class RateGoal:
    """The achievable part of a wish, as shares of full speed; `speed` is the requested one.

    `had` is the share of the wish that joints and motors can fulfil.
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
    """The speed of one leg: its mean and its final value."""

    kind: Kind
    mean: Rates
    end: Rates
    slope: float

    @property
    def ramp_s(self) -> float:
        """Time to brake from the mean speed; each axis takes its share of that time."""
        return max(map(abs, self.mean)) / self.slope if self.slope > 0.0 else 0.0

    def slowed(self, shares: tuple[float, ...]) -> Paced:
        """Return the speed with some axes slowed; a slowed axis does not accelerate."""
        mean = tuple(a * share for a, share in zip(self.mean, shares, strict=True))
        end = tuple(
            b if share >= 1.0 else a for a, b, share in zip(mean, self.end, shares, strict=True)
        )
        return Paced(self.kind, mean, end, self.slope)


class Pacer:
    """The ramp of one jog. `ramp_s` is the time from rest to full speed."""

    def __init__(self, ramp_s: float, *, carries: bool) -> None:
        self._ramp_s = ramp_s
        self._carries = carries
        self._last: Paced | None = None
        self._until_s = -math.inf

    def kind(self, wished: Kind, now_s: float) -> Kind:
        """Return the space and frame to move in: a moving arm first stops in its present one."""
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
        # a released jog brakes as fast as it has accelerated
        slope = (
            last.slope if last is not None and not most else self._slope(most / goal.speed, time_s)
        )
        return Paced(kind, *ramped(now, goal.shares, slope, time_s), slope)

    def stand(self) -> None:
        """Start again from rest."""
        self._last = None

    def taken(self, paced: Paced, time_s: float, now_s: float) -> None:
        """Take into account a leg that is driven now, or after the previous one."""
        self._last = paced
        self._until_s = max(self._until_s, now_s) + time_s if self._carries else now_s + time_s

    def _slope(self, share: float, time_s: float) -> float:
        ramp_s = self._ramp_s if self._carries else min(self._ramp_s, time_s)
        return share / ramp_s if ramp_s > 0.0 else math.inf

    def _moving(self, now_s: float) -> Paced | None:
        """Return the speed of an arm that is moving or has just finished a burst."""
        last = self._last
        if last is None or not any(last.end) or now_s > self._until_s + STALE_S:
            return None
        return last


def _along(goal: RateGoal, before: Rates) -> Rates:
    """Return the previous speed in the goal's direction, if both point about the same way."""
    together = sum(a * b for a, b in zip(goal.shares, before, strict=True))
    if not goal.most or together <= 0.0:
        return (0.0,) * len(goal.shares)
    share = min(max(map(abs, before)) / goal.most, 1.0)
    return tuple(each * share for each in goal.shares)


# How fast a jog can go at the arm's position, with all axes slowed by the same factor.
#
# Near a singularity, a line of the tip demands more and more of the joints. The demand of a leg is
# found by solving it.

ANGULAR_JOG_RAD_S = math.radians(45.0)
"""Full speed of pitch, roll and yaw in a Cartesian jog, before joint limits slow it."""

TRIES = 12
FAST_ENOUGH = 0.93  # a leg that needs at least this share of its time is fast enough
NO_SLOWER = 1.0 + 1e-9
LEAST, MOST = 0.05, 4.0  # range of the factor by which one try corrects the share


def axis_names(config: ArmConfig, space: Space) -> tuple[str, ...]:
    """Return the axes of a jog in a space, the gripper last."""
    if space is Space.JOINT:
        return (*config.model.arm.joint_names, GRIPPER_AXIS)
    yaw = (YAW_AXIS,) if config.model.arm.has_yaw else ()
    return (*CARTESIAN_AXES, *yaw, GRIPPER_AXIS)


class Scale:
    """The full speeds of the axes, and the share of them that a leg can reach."""

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

    def share(
        self,
        way: JogPath,
        start: ArmCoordinates,
        time_s: float,
        speed: float,
    ) -> float:
        """Return the share of a path's speed at which a leg of `time_s` keeps all limits.

        The limits are scaled by `speed`. If only a short part of the path can be solved, the share
        is small.
        """
        share, known = 1.0, 0.0
        for _ in range(TRIES):
            there = way.at(time_s * share)
            if there is None:
                share = max(share / 2.0, known)
                if share == known:
                    break
                continue
            need_s = self._speeds.duration_s(start, there, speed)
            if need_s <= time_s * NO_SLOWER:
                known = max(known, share)
                if share >= 1.0 or need_s >= FAST_ENOUGH * time_s:
                    break
            # demand grows faster than the share near a singularity: aim a little below the limit
            share *= min(max(0.97 * time_s / need_s if need_s else MOST, LEAST), MOST)
            share = min(share, 1.0)
        return known or share
