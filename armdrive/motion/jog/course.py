"""The course of a held jog: takes the operator's wish and the time, returns the next leg.

A leg is as long as one burst or one queued segment. Its speed follows from a ramp and the
speeds that joints and motors can reach (rates.py: the jog slows down near a singularity), and from
the distance to the next bound (bounds.py), so that the arm can always stop before it. If no step is
left, the course ends with a reason. This code moves nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from armdrive.config.arm import ArmConfig
from armdrive.motion.jog.bounds import (
    Bounds,
    Free,
    JogEnded,
    JogPath,
    Kind,
    Span,
    at_limits,
    jog_path,
    spans_of,
)
from armdrive.motion.jog.rates import (
    Paced,
    Pacer,
    RateGoal,
    Rates,
    Scale,
    axis_names,
    braking_share,
    shares_to_stop,
)
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import GRIPPER_AXIS, Jog, Space
from armdrive.runtime.position import ArmCoordinates, MotionSegment

LAST_STEPS = 2  # the last steps before a bound are made at once, or the arm would creep forever
TOUCHING = 1e-6  # an axis limited to this share of its speed has reached its limit


@dataclass(frozen=True, slots=True)
class Wish:
    """The jog that the operator wants now; `speed` is a share of the limits.

    `bounded` is false while the position is unknown: then no limits and guards end the jog.
    """

    jog: Jog
    speed: float
    bounded: bool = True


@dataclass(frozen=True, slots=True)
class JogProposal:
    """A leg that may be driven, and its speed. `note` names the axes that are at their limits."""

    leg: MotionSegment
    paced: Paced
    note: str = ""

    def shortened(self, share: float) -> JogProposal:
        """Return a share of the leg, at its speed."""
        if share >= 1.0:
            return self
        start, end = self.leg.start, self.leg.end
        leg = MotionSegment(start, start.towards(end, share), self.leg.duration_s * share)
        return replace(self, leg=leg)


class JogCourse:
    """One jog, from rest to rest. `propose` changes nothing; `take` accepts the proposal.

    `note` is the latest note that the caller has shown to the operator.
    """

    def __init__(
        self, config: ArmConfig, speeds: SpeedLimits, *, queued: bool, run_on_s: float
    ) -> None:
        """`queued`: the speed carries over from leg to leg. `run_on_s`: the arm's, after a stop."""
        self.note = ""
        self._run_on_s = run_on_s
        self._config = config
        self._speeds = speeds
        self._pacer = Pacer(config.motion.jog_ramp_s, carries=queued)
        self._scale = Scale(config, speeds)
        self._bounds = Bounds(config, speeds.transmission)

    def propose(
        self, wish: Wish, start: ArmCoordinates, time_s: float, now_s: float
    ) -> JogProposal | JogEnded:
        """Return the next leg, which lasts `time_s` or a little longer, or why there is none.

        Raises `BadRequest` for an unknown frame.
        """
        wished = wish.jog.space, wish.jog.frame
        kind = self._pacer.kind(wished, now_s)
        goal = self._goal(wish, start, time_s)
        if kind != wished:  # the arm still moves in another space or frame: come to rest first
            goal = RateGoal((0.0,) * len(axis_names(self._config, kind[0])), wish.speed)
        paced = self._pacer.paced(kind, goal, time_s, now_s)
        if not any(paced.mean) and not any(paced.end):
            return JogEnded("")
        if not wish.bounded:
            return self._proposal(self._way(kind, start, paced.mean), start, paced, time_s, time_s)
        return self._bounded(paced, start, time_s)

    def take(self, proposal: JogProposal, now_s: float) -> None:
        """Accept a proposal: its leg is driven now, or after the previous one."""
        leg = proposal.leg
        self._pacer.taken(proposal.paced, leg.duration_s, now_s)
        self._bounds.went(leg.start.joints, leg.end.joints)

    def stand(self) -> None:
        """Start again from rest."""
        self._pacer.stand()

    def _goal(self, wish: Wish, start: ArmCoordinates, time_s: float) -> RateGoal:
        """Return the part of a wish that joints and motors can fulfil."""
        jog, speed = wish.jog, wish.speed
        kind = jog.space, jog.frame
        shares = tuple(jog.amount(name) * speed for name in axis_names(self._config, jog.space))
        if not any(shares):
            return RateGoal(shares, speed)
        way = self._way(kind, start, shares)
        had = self._scale.share(way, start, time_s, speed)
        return RateGoal(tuple(each * had for each in shares), speed, had)

    # -- bounds -------------------------------------------------------------------------------

    def _bounded(
        self, paced: Paced, start: ArmCoordinates, time_s: float
    ) -> JogProposal | JogEnded:
        """Return a leg after which the arm can still stop before every bound."""
        spans = spans_of(self._config, start)
        shares = self._apart(paced, start, spans, time_s)
        names = axis_names(self._config, paced.kind[0])
        stopped = [
            name
            for name, mean, share in zip(names, paced.mean, shares, strict=True)
            if mean and share <= TOUCHING
        ]
        note = at_limits(stopped) if stopped else ""
        paced = paced.slowed(shares)
        if stopped and not any(paced.mean):
            return JogEnded(note)
        way = self._way(paced.kind, start, paced.mean, spans)
        # an even ramp down to rest covers half the way that its time would at the mean speed
        look_s = time_s + max(paced.ramp_s / 2.0, self._run_on_s)
        free = self._bounds.free(way, start.joints, look_s)
        if free.free_s >= look_s:
            return self._proposal(way, start, paced, time_s, time_s, note)
        bound = way.at(free.free_s)
        left = 0 if bound is None else self._steps_between(start, bound)
        if not left:
            return self._bounds.ended(way, start.joints, free.beyond_s)
        share = self._share(free.reach_s, free.clear_s, time_s, paced.ramp_s)
        # the ramp would halve the rest of the way again and again without reaching its end
        if left <= LAST_STEPS and free.free_s <= time_s:
            share = free.free_s / time_s
        paced = paced.slowed((share,) * len(names))
        return self._proposal(way, start, paced, time_s * share, time_s, note)

    def _steps_between(self, here: ArmCoordinates, there: ArmCoordinates) -> int:
        """Return how many whole steps the busiest motor makes from one point to another."""
        transmission = self._speeds.transmission
        return (there.motors(transmission) - here.motors(transmission)).largest

    def _share(self, reach_s: float, clear_s: float, time_s: float, ramp_s: float) -> float:
        """Return the share of its speed that a leg may have.

        A stopped device ends at its target at the latest, so it never leaves its reach; only the
        guards need the announced run-on as an extra margin.
        """
        share = min(braking_share(each_s, time_s, ramp_s) for each_s in (reach_s, clear_s))
        if clear_s < reach_s:
            share = min(share, clear_s / (time_s + self._run_on_s))
        return share

    def _apart(
        self, paced: Paced, start: ArmCoordinates, spans: tuple[Span, ...], time_s: float
    ) -> tuple[float, ...]:
        """Return the speed share of each axis that stops at its limit while the others continue."""
        rates = self._rates(paced.kind, paced.mean)
        ramps_s = [abs(share) / paced.slope if paced.slope else 0.0 for share in paced.mean]
        if paced.kind[0] is Space.JOINT:
            return tuple(shares_to_stop(start.values, rates, spans, time_s, ramps_s))
        fingers = shares_to_stop((start.opening_mm,), rates[-1:], spans[-1:], time_s, ramps_s[-1:])
        return (*(1.0 for _ in rates[:-1]), *fingers)

    # -- ways ---------------------------------------------------------------------------------

    def _proposal(
        self,
        way: JogPath,
        start: ArmCoordinates,
        paced: Paced,
        at_s: float,
        time_s: float,
        note: str = "",
    ) -> JogProposal | JogEnded:
        there = way.at(at_s)
        if there is None:
            return self._bounds.ended(way, start.joints, at_s)
        lasts_s = max(time_s, self._speeds.duration_s(start, there, 1.0))
        return JogProposal(MotionSegment(start, there, lasts_s), paced, note)

    def _way(
        self,
        kind: Kind,
        start: ArmCoordinates,
        shares: Rates,
        spans: tuple[Span, ...] | None = None,
    ) -> JogPath:
        return jog_path(self._config, kind, start, self._rates(kind, shares), spans)

    def _rates(self, kind: Kind, shares: Rates) -> Rates:
        """Return the rates in rad/s and mm/s for shares of full speed."""
        full = self._scale.full(kind[0])
        return tuple(share * most for share, most in zip(shares, full, strict=True))


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
    way, pieces = _way(config, jog, start, known=known)
    bounds = Bounds(config, speeds.transmission) if known else None
    ended = JogEnded(at_limits(_clipped(config, jog, start)) if known else "")
    whole_s = _least_s(config, speeds, jog) / speed
    here, legs = start, []
    for piece in range(pieces):
        low, share = piece / pieces, 1.0 / pieces
        free = Free(share, share)
        if bounds is not None:
            free = bounds.free(way, here.joints, share, low)
        there = way.at(low + free.free_s)
        if there is not None and there != here:
            lasts_s = max(speeds.duration_s(here, there, speed), free.free_s * whole_s)
            legs.append(MotionSegment(here, there, lasts_s))
        if bounds is not None and math.isfinite(free.beyond_s):
            ended = bounds.ended(way, here.joints, low + free.beyond_s)
            break
        here = there or here
    return JogIncrement(tuple(legs), ended)


def _least_s(config: ArmConfig, speeds: SpeedLimits, jog: Jog) -> float:
    """Return the least duration of a tip increment: that of a held jog over the same distance."""
    if jog.space is Space.JOINT:
        return 0.0
    full = Scale(config, speeds).full(jog.space)
    *tip, _ = zip(amounts_of(config, jog), full, strict=True)
    return max(abs(amount) / most for amount, most in tip)


def _way(config: ArmConfig, jog: Jog, start: ArmCoordinates, *, known: bool) -> tuple[JogPath, int]:
    """Return the path of an increment, scaled to one second, and its number of pieces."""
    amounts = amounts_of(config, jog)
    spans = spans_of(config, start) if known else None
    way = jog_path(config, (jog.space, jog.frame), start, amounts, spans)
    if jog.space is Space.JOINT:
        return way, 1
    *turns, _ = amounts[3:]
    pieces = max(math.hypot(*amounts[:3]) / PIECE_MM, *(abs(turn) / PIECE_RAD for turn in turns))
    return way, max(math.ceil(pieces), 1)


def amounts_of(config: ArmConfig, jog: Jog) -> tuple[float, ...]:
    """Return an increment in mm and rad, converted from degrees."""
    lengths = ("x", "y", "z", GRIPPER_AXIS)
    return tuple(
        amount if name in lengths else math.radians(amount)
        for name, amount in ((name, jog.amount(name)) for name in axis_names(config, jog.space))
    )


def _clipped(config: ArmConfig, jog: Jog, start: ArmCoordinates) -> list[str]:
    """Return the axes that stop at their limits while the others continue."""
    names = axis_names(config, jog.space)
    spans = spans_of(config, start)
    places = start.values
    amounts = amounts_of(config, jog)
    if jog.space is Space.CARTESIAN:
        names, spans, places, amounts = names[-1:], spans[-1:], places[-1:], amounts[-1:]
    return [
        name
        for name, place, amount, (low, high) in zip(names, places, amounts, spans, strict=True)
        if not low <= place + amount <= high
    ]
