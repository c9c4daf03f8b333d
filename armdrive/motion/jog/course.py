"""The course of a held jog: an operator's wish and the clock in, the next leg out. Moves nothing.

A leg is as long as one burst or one queued segment. Its speed comes from a ramp, from what joints
and motors can do there (rates.py: the jog slows near a singularity), and from the way that is left
to the next bound (bounds.py), so that the arm could always stop before it. Where no step is left,
the course has ended and says why.
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
    in_base,
    jog_path,
    spans_of,
)
from armdrive.motion.jog.rates import Paced, Pacer, RateGoal, Scale, axis_names
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import GRIPPER_AXIS, Jog, Space
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from kinematics.five_axis.rates import Rates, braked, shares_to_stop

LAST_STEPS = 2
"""The last steps before a bound are made at once, lest the arm creep for ever."""

TOUCHING = 1e-6
"""An axis that can go on by no more of its speed than this (1 is all of it) stands at its end."""


@dataclass(frozen=True, slots=True)
class Wish:
    """What an operator wants now: `speed` is a share of the limits.

    Where the position is not `known` there are no bounds.
    """

    jog: Jog
    speed: float
    known: bool = True


@dataclass(frozen=True, slots=True)
class Terms:
    """What a jog has to reckon with of a device.

    `ramp_s` is how long the jog takes to full speed at most, `queued` whether speed carries on
    from leg to leg, `run_on_s` how long the arm may run on when it is stopped.
    """

    ramp_s: float
    queued: bool
    run_on_s: float


@dataclass(frozen=True, slots=True)
class JogProposal:
    """A leg that may be driven, and the speed that comes with it.

    `note` says which axes stay behind at their limits.
    """

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
    """One jog, from rest to rest. `propose` changes nothing until its answer is `take`n.

    `note` is what was last said of it, kept by whoever says it.
    """

    def __init__(self, config: ArmConfig, speeds: SpeedLimits, terms: Terms) -> None:
        self.note = ""
        self._config = config
        self._speeds = speeds
        self._terms = terms
        self._pacer = Pacer(terms.ramp_s, carries=terms.queued)
        self._scale = Scale(config, speeds)
        self._bounds = Bounds(config, speeds.transmission)

    def propose(
        self, wish: Wish, start: ArmCoordinates, time_s: float, now_s: float
    ) -> JogProposal | JogEnded:
        """Return the next leg, which lasts `time_s` or a little longer, or why there is none.

        Raises `BadRequest` for a frame that nobody knows.
        """
        wished = wish.jog.space, wish.jog.frame
        kind = self._pacer.kind(wished, now_s)
        goal = self._goal(wish, start, time_s)
        if kind != wished:  # the arm still moves in another space or frame: come to rest first
            goal = RateGoal((0.0,) * len(axis_names(self._config, kind[0])), wish.speed)
        paced = self._pacer.paced(kind, goal, time_s, now_s)
        if not any(paced.mean) and not any(paced.end):
            return JogEnded("")
        if not wish.known:
            return self._proposal(self._way(kind, start, paced.mean), start, paced, time_s, time_s)
        return self._bounded(paced, start, time_s)

    def take(self, proposal: JogProposal, now_s: float) -> None:
        """Hear that a leg is driven now, or behind the one before."""
        leg = proposal.leg
        self._pacer.taken(proposal.paced, leg.duration_s, now_s)
        self._bounds.went(leg.start.joints, leg.end.joints)

    def stand(self) -> None:
        """Hear that the arm has come to rest, wherever."""
        self._pacer.stand()

    def _goal(self, wish: Wish, start: ArmCoordinates, time_s: float) -> RateGoal:
        """Return what can be had of a wish."""
        jog, speed = wish.jog, wish.speed
        kind = jog.space, jog.frame
        shares = tuple(jog.amount(name) * speed for name in axis_names(self._config, jog.space))
        if not any(shares):
            return RateGoal(shares, speed)
        guess = 1.0
        if jog.space is Space.CARTESIAN:
            rates = in_base(self._config, kind, start, self._rates(kind, shares))
            guess = self._scale.first_guess(start, rates, speed)
        way = self._way(kind, start, shares)
        had = self._scale.share(way, start, time_s, speed, guess)
        return RateGoal(tuple(each * had for each in shares), speed, had)

    # -- bounds -------------------------------------------------------------------------------

    def _bounded(
        self, paced: Paced, start: ArmCoordinates, time_s: float
    ) -> JogProposal | JogEnded:
        """Return a leg with which the arm could still stop before every bound."""
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
        look_s = time_s + max(paced.ramp_s / 2.0, self._terms.run_on_s)
        free = self._bounds.free(way, start.joints, look_s)
        if free.free_s >= look_s:
            return self._proposal(way, start, paced, time_s, time_s, note)
        bound = way.at(free.free_s)
        left = 0 if bound is None else self._steps_between(start, bound)
        if not left:
            return self._bounds.ended(way, start.joints, free.beyond_s)
        share = self._share(free.reach_s, free.clear_s, time_s, paced.ramp_s)
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

        A device that is stopped ends at the latest where it was sent to, so that it never passes
        the edge of its reach; only the guards are kept from what it is announced to run on.
        """
        share = min(braked(reach_s, time_s, ramp_s), braked(clear_s, time_s, ramp_s))
        if clear_s < reach_s:
            share = min(share, clear_s / (time_s + self._terms.run_on_s))
        return share

    def _apart(
        self, paced: Paced, start: ArmCoordinates, spans: tuple[Span, ...], time_s: float
    ) -> tuple[float, ...]:
        """Return by how much axes are slowed that end by themselves while the others go on."""
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
        """Return the rates in rad/s and mm/s of shares of full speed."""
        full = self._scale.full(kind[0])
        return tuple(share * most for share, most in zip(shares, full, strict=True))


# An increment of a jog: legs as far as the bounds allow, and what bounds it.
#
# Joints turn in proportion. The tip keeps to its line: a long increment is cut into pieces.

PIECE_MM = 10.0
PIECE_RAD = math.radians(5.0)
"""How long the pieces of a line are at most: the tip leaves it by some tenths of a mm at most."""


@dataclass(frozen=True, slots=True)
class JogIncrement:
    """Legs end to end, and why they lead less far than asked, where they do."""

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
    """Return how an increment is driven; without bounds where the position is not known.

    Raises `BadRequest` for a frame that nobody knows.
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
    """Return how long an increment of the tip takes at least: no less than if it were held."""
    if jog.space is Space.JOINT:
        return 0.0
    full = Scale(config, speeds).full(jog.space)
    *tip, _ = zip(_amounts(config, jog), full, strict=True)
    return max(abs(amount) / most for amount, most in tip)


def _way(config: ArmConfig, jog: Jog, start: ArmCoordinates, *, known: bool) -> tuple[JogPath, int]:
    """Return the way of an increment, which lasts a second, and into how many pieces it is cut."""
    amounts = _amounts(config, jog)
    spans = spans_of(config, start) if known else None
    way = jog_path(config, (jog.space, jog.frame), start, amounts, spans)
    if jog.space is Space.JOINT:
        return way, 1
    *turns, _ = amounts[3:]
    pieces = max(math.hypot(*amounts[:3]) / PIECE_MM, *(abs(turn) / PIECE_RAD for turn in turns))
    return way, max(math.ceil(pieces), 1)


def _amounts(config: ArmConfig, jog: Jog) -> tuple[float, ...]:
    """Return an increment in mm and rad; people give degrees."""
    lengths = ("x", "y", "z", GRIPPER_AXIS)
    return tuple(
        amount if name in lengths else math.radians(amount)
        for name, amount in ((name, jog.amount(name)) for name in axis_names(config, jog.space))
    )


def _clipped(config: ArmConfig, jog: Jog, start: ArmCoordinates) -> list[str]:
    """Return the axes that end at their limits while the others go on."""
    names = axis_names(config, jog.space)
    spans = spans_of(config, start)
    places = start.values
    amounts = _amounts(config, jog)
    if jog.space is Space.CARTESIAN:
        names, spans, places, amounts = names[-1:], spans[-1:], places[-1:], amounts[-1:]
    return [
        name
        for name, place, amount, (low, high) in zip(names, places, amounts, spans, strict=True)
        if not low <= place + amount <= high
    ]
