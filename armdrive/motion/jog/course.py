"""The course of a jog: the legs of a held jog one by one, and those of an increment.

A leg of a held jog is as long as one burst or one queued segment. Its speed follows from the
operator's wish, the ramp, the distance to the next bound (bounds.py), so that the arm can always
stop before it, and what joints and motors can reach: a line slows down near a singularity. If no
step is left, the course ends with a reason. This code moves nothing.

Speeds are shares of full speed, one for each axis of the space. On a device with a queue, the speed
carries over from leg to leg, and changes by a ramp. Any other device stands between two bursts,
which have no ramp.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import add, sub

from armdrive.config.arm import ArmConfig
from armdrive.motion.jog.bounds import (
    Bounds,
    Free,
    JogEnded,
    JogPath,
    Kind,
    Rates,
    Span,
    at_limits,
    axis_names,
    full_speeds,
    ways_left,
)
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import GRIPPER_AXIS, Jog, Space
from armdrive.runtime.position import ArmCoordinates, MotionSegment

TOUCHING = 1e-6  # an axis limited to this share of its speed has reached its limit
TRIES = 12  # attempts to slow a leg down to what joints and motors can reach
FAST_ENOUGH = 0.93  # a leg that needs at least this share of its time is fast enough
SLOWEST, FASTEST = 0.05, 4.0  # range of the factor by which one attempt corrects the speed
ROUNDING = 1.0 + 1e-9  # a leg that needs no more than this share of its time is slow enough


@dataclass(frozen=True, slots=True)
class Wish:
    """The jog that the operator wants now; `speed` is a share of the limits.

    `bounded` is false while the position is unknown: then no limits and guards end the jog.
    """

    jog: Jog
    speed: float
    bounded: bool = True


@dataclass(frozen=True, slots=True)
class JogSpeed:
    """The speed of one leg: its mean and its final value."""

    kind: Kind
    mean: Rates
    end: Rates

    def slowed(self, shares: Sequence[float]) -> JogSpeed:
        """Return the speed with some axes slowed; a slowed axis does not accelerate."""
        each = tuple(zip(self.mean, self.end, shares, strict=True))
        mean = tuple(mean * share for mean, _, share in each)
        return JogSpeed(
            self.kind, mean, tuple(b if share >= 1.0 else a * share for a, b, share in each)
        )


@dataclass(frozen=True, slots=True)
class JogProposal:
    """A leg that may be driven, and its speed. `note` names the axes that are at their limits."""

    leg: MotionSegment
    speed: JogSpeed
    note: str = ""

    def shortened(self, share: float) -> JogProposal:
        """Return a share of the leg, at its speed."""
        start, end = self.leg.start, self.leg.end
        leg = MotionSegment(start, start.towards(end, share), self.leg.duration_s * min(share, 1.0))
        return replace(self, leg=leg)


class JogCourse:
    """One held jog, from rest to rest. `propose` changes nothing; `take` accepts the proposal.

    `note` is the latest note that the caller has shown to the operator.
    """

    def __init__(
        self, config: ArmConfig, speeds: SpeedLimits, *, queued: bool, run_on_s: float
    ) -> None:
        """`queued`: the speed carries over from leg to leg. `run_on_s`: the arm's, after a stop."""
        self.note = ""
        self._config = config
        self._speeds = speeds
        self._ramp_s = config.motion.jog_ramp_s if queued else 0.0  # from rest to full speed
        self._run_on_s = run_on_s
        self._full = {space: full_speeds(config, speeds, space) for space in Space}
        self._bounds = Bounds(config)
        self._moving: JogSpeed | None = None

    def propose(self, wish: Wish, start: ArmCoordinates, time_s: float) -> JogProposal | JogEnded:
        """Return the next leg, which lasts `time_s`, or why there is none.

        Raises `BadRequest` for an unknown frame.
        """
        speed, note = self._towards(wish, time_s), ""
        if not any((*speed.mean, *speed.end)):
            return JogEnded("")
        if wish.bounded:
            speed, note = self._before_limits(speed, start, time_s)
            if note and not any(speed.mean):
                return JogEnded(note)
        rates = self._rates(speed)
        way = JogPath(self._config, speed.kind, start, rates, bounded=wish.bounded)
        before = self._before_bounds(way, start, speed, time_s) if wish.bounded else 1.0
        if isinstance(before, JogEnded):
            return before
        # an arm that still slows down may be faster than it is wanted
        fraction = max(wish.speed, *map(abs, speed.mean))
        share = self._possible(way, start, before, time_s, fraction)
        there = way.at(share * time_s)
        if there is None:
            return self._bounds.ended(way, start.joints, share * time_s)
        speed = speed.slowed((share,) * len(rates))
        return JogProposal(MotionSegment(start, there, time_s), speed, note)

    def take(self, proposal: JogProposal) -> None:
        """Accept a proposal: its leg is driven now, or after the previous one."""
        moves = self._ramp_s and any(proposal.speed.end)
        self._moving = proposal.speed if moves else None

    def stand(self) -> None:
        """Start again from rest."""
        self._moving = None

    def _towards(self, wish: Wish, time_s: float) -> JogSpeed:
        """Return the speed of the next leg on the way to a wish."""
        kind = wish.jog.space, wish.jog.frame
        names = axis_names(self._config, wish.jog.space)
        goal = tuple(wish.jog.amount(name) * wish.speed for name in names)
        now = (0.0,) * len(goal)
        if self._moving is not None:
            now = self._moving.end
            if self._moving.kind != kind:  # first come to rest in the present space and frame
                kind, goal = self._moving.kind, (0.0,) * len(now)
        return JogSpeed(kind, *ramped(now, goal, self._ramp_s, time_s))

    def _rates(self, speed: JogSpeed) -> Rates:
        """Return the mean speed in rad/s and mm/s."""
        full = self._full[speed.kind[0]]
        return tuple(share * most for share, most in zip(speed.mean, full, strict=True))

    def _before_limits(
        self, speed: JogSpeed, start: ArmCoordinates, time_s: float
    ) -> tuple[JogSpeed, str]:
        """Return a speed at which each axis stops at its limit while the others continue."""
        space, _ = speed.kind
        ramps_s = [self._ramp_s * abs(share) for share in speed.mean]
        left = ways_left(self._config, space, start)
        shares = shares_to_stop(left, self._rates(speed), time_s, ramps_s)
        each = zip(axis_names(self._config, space), speed.mean, shares, strict=True)
        stopped = [name for name, mean, share in each if mean and share <= TOUCHING]
        return speed.slowed(shares), at_limits(stopped)

    def _possible(
        self, way: JogPath, start: ArmCoordinates, share: float, time_s: float, fraction: float
    ) -> float:
        """Return the share of a speed, at most `share`, at which joints and motors keep up.

        Near a singularity, a line of the tip demands more and more of the joints.
        """
        most, known = share, 0.0
        for _ in range(TRIES):
            there = way.at(share * time_s)
            need_s = 0.0 if there is None else self._speeds.duration_s(start, there, fraction)
            if need_s <= time_s * ROUNDING:
                known = max(known, share)
                if share >= most or need_s >= FAST_ENOUGH * time_s:
                    break
            # demand grows faster than the share near a singularity: aim a little below the limit
            share *= min(max(0.97 * time_s / need_s, SLOWEST), FASTEST) if need_s else FASTEST
            share = min(share, most)
        return known or share

    def _before_bounds(
        self, way: JogPath, start: ArmCoordinates, speed: JogSpeed, time_s: float
    ) -> float | JogEnded:
        """Return the share of its speed after which the arm can still stop before every bound."""
        ramp_s = self._ramp_s * max(map(abs, speed.mean))
        # an even ramp down to rest covers half the way that its time would at the mean speed
        look_s = time_s + max(ramp_s / 2.0, self._run_on_s)
        free = self._bounds.free(way, start.joints, look_s)
        if free.free_s >= look_s:
            return 1.0
        bound = way.at(free.free_s)
        # the ramp halves the rest of the way again and again, until not even a step is left
        if bound is None or not self._is_a_step(start, bound):
            return self._bounds.ended(way, start.joints, free.beyond_s)
        # A stopped device ends at its target at the latest, so it never leaves its reach; only the
        # guards need the announced run-on as an extra margin.
        most = free.free_s / (time_s + self._run_on_s) if free.guarded else 1.0
        return min(braking_share(free.free_s, time_s, ramp_s), most)

    def _is_a_step(self, here: ArmCoordinates, there: ArmCoordinates) -> bool:
        """Return whether any motor makes a step from one point to another."""
        transmission = self._speeds.transmission
        return there.motors(transmission) != here.motors(transmission)


# The arithmetic of ramps and braking. It runs many times a second, so it uses plain floats and
# tuples and checks nothing.


def ramped(now: Rates, wish: Rates, ramp_s: float, time_s: float) -> tuple[Rates, Rates]:
    """Return the mean and the final speeds of a leg of `time_s` on a ramp from `now` to `wish`.

    All speeds change in proportion, and the one with the greatest change by 1 in `ramp_s`. So a
    line that starts from rest is straight, and a change of direction passes through zero.
    """
    gaps = list(map(sub, wish, now))
    takes_s = ramp_s * max(map(abs, gaps))
    if takes_s <= time_s:
        return _further(wish, -0.5 * takes_s / time_s, gaps), wish
    share = time_s / takes_s
    return _further(now, 0.5 * share, gaps), _further(now, share, gaps)


def _further(place: Rates, share: float, gaps: Sequence[float]) -> Rates:
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
    left: Sequence[Span], rates: Rates, time_s: float, ramps_s: Sequence[float]
) -> list[float]:
    """Return the share of its rate at which each axis still stops within the way that is left.

    `left` is the way down, negative, and the way up; `ramps_s` is the time that each axis needs to
    brake to rest.
    """
    shares = []
    for (down, up), rate, ramp_s in zip(left, rates, ramps_s, strict=True):
        way_s = (up if rate > 0.0 else down) / rate if rate else math.inf
        shares.append(1.0 if way_s > time_s + ramp_s else braking_share(way_s, time_s, ramp_s))
    return shares


# Increments: the legs of an incremental jog, as far as the bounds allow.
#
# Joints turn in proportion. The tip stays on its line: a long increment is cut into pieces, so that
# the tip deviates by a few tenths of a millimetre at most.

PIECE_MM = 10.0
PIECE_RAD = math.radians(5.0)


@dataclass(frozen=True, slots=True)
class JogIncrement:
    """The legs of an increment, and why they end early, if they do."""

    legs: tuple[MotionSegment, ...]
    ended: JogEnded


def stride(
    config: ArmConfig,
    speeds: SpeedLimits,
    jog: Jog,
    speed: float,
    start: ArmCoordinates,
    *,
    known: bool,
) -> JogIncrement:
    """Return the legs of an increment; without bounds if the position is not known.

    Raises `BadRequest` for an unknown frame.
    """
    amounts = amounts_of(config, jog)
    way = JogPath(config, (jog.space, jog.frame), start, amounts, bounded=known)
    pieces, whole_s = 1, 0.0
    if jog.space is Space.CARTESIAN:
        x, y, z, *turns, _ = amounts
        pieces = math.ceil(
            max(math.hypot(x, y, z) / PIECE_MM, *(abs(a) / PIECE_RAD for a in turns))
        )
        # no faster than a held jog
        full = full_speeds(config, speeds, jog.space)
        whole_s = max(abs(a) / most for a, most in zip(amounts[:-1], full, strict=False)) / speed
    ended = JogEnded(at_limits(_clipped(config, jog, start)) if known else "")
    bounds, here, legs = Bounds(config), start, []
    share = 1.0 / max(pieces, 1)
    for piece in range(max(pieces, 1)):
        low = piece * share
        free = bounds.free(way, here.joints, share, low) if known else Free(share)
        there = way.at(low + free.free_s)
        if there is not None and there != here:
            lasts_s = max(speeds.duration_s(here, there, speed), free.free_s * whole_s)
            legs.append(MotionSegment(here, there, lasts_s))
        if math.isfinite(free.beyond_s):
            ended = bounds.ended(way, here.joints, low + free.beyond_s)
            break
        here = there or here
    return JogIncrement(tuple(legs), ended)


def amounts_of(config: ArmConfig, jog: Jog) -> Rates:
    """Return an increment in mm and rad, converted from degrees."""
    lengths = ("x", "y", "z", GRIPPER_AXIS)
    return tuple(
        jog.amount(name) if name in lengths else math.radians(jog.amount(name))
        for name in axis_names(config, jog.space)
    )


def _clipped(config: ArmConfig, jog: Jog, start: ArmCoordinates) -> list[str]:
    """Return the axes that stop at their limits while the others continue."""
    names, left = axis_names(config, jog.space), ways_left(config, jog.space, start)
    each = zip(names, amounts_of(config, jog), left, strict=True)
    return [name for name, amount, (down, up) in each if not down <= amount <= up]
