"""Motion of MKS drives by steering: each is given a new target again and again, in flight.

At a fixed period every motor that moves is told the speed that brings it, by the end of the period,
to where the motion should be then, and a target that it would not reach before the next order but
no later than announced if none came: as far ahead as it goes one way. So drives do not brake
between segments, and stop by themselves when their host dies. Speeds are whole rpm; what rounding
leaves over is in the next period's way, so nothing adds up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.dialects.bus.observer import Finding, ObservedDrive
from armdrive.dialects.bus.way import KEPT_S, Course, Lead, Way
from armdrive.dialects.mks.stops import shared_acc
from armdrive.dialects.mks.wire import MksWire
from armdrive.tasks import MoveAlong, RequestRejected
from firmware_protocol.mks import (
    COUNTS_S_PER_RPM,
    SPEED_MAX_RPM,
    TARGET_MAX,
    MoveAbsoluteAxis,
    acc_of,
    slope_of,
)
from kinematics.spaces import Motors

SLOW_RPM = LAST_RPM = 3
"""Slower than this, a drive is sent to the end of the period alone: it stands there."""
CREEP_RPM = 32
"""Slower than this, or behind, one is told to be there when it is announced."""
CATCH_UP, CATCH_UP_RPM = 1.1, 1
"""How much faster than planned a drive may be told to go that is behind: its joint may be planned
at its limit, where motors are coupled it may turn by twice as much more, and 1 rpm is what whole
rpm leave over of a slow one."""
SHOWS_PERIODS = 1.5
"""A drive whose orders stay the same is given them anew after so long: who takes none says so."""
BRAKES_SURELY = 1.1
"""How much steeper than it just needs a drive brakes at its end."""
HEEDED_S = 0.003
"""An order takes so long to be heeded at most: a frame, those before it, a loop that is behind."""


class Trip:
    """One motion under way: where its segments come from, and how far it is."""

    def __init__(self, request: MoveAlong, way: Way, period_s: float) -> None:
        self.way = way
        self.ahead_s = request.ahead_s
        self.held_back = request.held_back
        """Whether somebody has paused the arm."""
        self.time_s = 0.0
        """Where on the way the motors are now."""
        self.sent_s = 0.0
        """How far on it they have been sent."""
        self.due_s = -math.inf
        """When the drives are to be steered next."""
        self.underruns = 0
        """How often there was nothing left to be driven although more was to come."""
        self.ending = False
        """Whether nothing more is to be drawn, for now or for ever."""
        self.sent_all = False
        """Whether nothing is left to be steered."""
        self._period_s = period_s
        self._segments = request.segments
        self._exhausted = False
        self._steered_s = -math.inf
        self._longest_s = 0.0

    def at_s(self, now_s: float) -> float:
        """Return where on the way the motors should be by now."""
        since_s = now_s - self._steered_s if math.isfinite(self._steered_s) else 0.0
        return min(self.time_s + since_s, self.sent_s)

    def go_on(self, now_s: float) -> None:
        """Let the time since the last steering pass, as far as the motors had been sent.

        Then draw what there is room for. Late periods do not add up.
        """
        self.due_s = max(self.due_s, now_s - self._period_s / 2.0) + self._period_s
        self.time_s, self._steered_s = self.at_s(now_s), now_s
        self.way.pass_by(self.time_s)
        held = self.held_back()
        dry = self.time_s >= self.way.end_s > 0.0 and not (self._exhausted or held)
        drew = False
        while not (self._exhausted or held) and self._has_room():
            segment = next(self._segments, None)
            self._exhausted = segment is None
            if segment is not None:
                self.way.draw(segment)
                self._longest_s, drew = segment.duration_s, True
        self.ending = self._exhausted or held
        self.underruns += dry and drew

    def _has_room(self) -> bool:
        left_s = self.way.end_s - self.time_s
        return left_s <= 0.0 or left_s + self._longest_s <= self.ahead_s + 1e-6

    def resume(self, time_s: float, now_s: float) -> None:
        """Go on from a time on the way that the motors are found to be at."""
        self.time_s = self.sent_s = time_s
        self._steered_s = self.due_s = now_s
        self.sent_all = False
        self.underruns += 1


class Steering:
    """Gives the drives their orders along a trip."""

    def __init__(self, wire: MksWire) -> None:
        self._wire = wire
        self.refused: RequestRejected | None = None
        """Why a target cannot be given."""

    def steer(self, trip: Trip) -> None:
        """Give every drive that moves its next order."""
        wire, period_s = self._wire, self._wire.settings.segment_s
        trip.go_on(wire.now_s)
        ahead_s = min(trip.time_s + trip.ahead_s, trip.way.end_s)
        trip.sent_s = ahead_s
        last = trip.ending and trip.time_s + period_s >= trip.way.end_s - 1e-9
        leads = [trip.way.lead(motor, trip.time_s, ahead_s) for motor in range(len(wire.drives))]
        speeds = [trip.way.speed(motor, trip.time_s, lead) for motor, lead in enumerate(leads)]
        shares = _shares_of(speeds)
        for motor, (drive, lead) in enumerate(zip(wire.drives, leads, strict=True)):
            drive.course.advance(wire.now_s)
            share = shares[motor]
            order = self._last(trip, motor) if last else self._next(trip, motor, lead, share)
            if order is None:
                continue
            target, rpm = order
            behind = drive.verdict is not None and drive.verdict.finding is Finding.BEHIND
            if last or behind or rpm < CREEP_RPM:
                target, rpm = self._in_time(trip, motor, target, rpm)
            if (refused := beyond(drive, target)) is not None:
                self.refused = refused
                return
            if target != drive.goal or (drive.moving and self._has_news(drive, rpm)):
                self._send(drive, target, rpm, share)
        if last:
            trip.time_s = trip.sent_s = trip.way.end_s
            ends = zip(wire.drives, trip.way.end, strict=True)
            trip.sent_all = all(drive.goal == end for drive, end in ends)

    def _send(self, drive: ObservedDrive, target: int, rpm: int, share: float) -> None:
        most = self._wire.settings.acceleration
        again = drive.moving and target == drive.goal
        kept = self._wire.orders[drive.node].acc if again else 0
        acc = ramp_to(drive.course, target, most, share, kept)
        self._wire.send(drive.node, MoveAbsoluteAxis(target, rpm, acc))

    def _in_time(self, trip: Trip, motor: int, target: int, rpm: int) -> tuple[int, int]:
        """Have a drive be at its target when that is announced, by where it was read.

        No faster than it was to go within the last second: where that is not enough it is not sent
        so far, and its way takes longer.
        """
        drive, ahead_s = self._wire.drives[motor], self._ahead_s(trip)
        fastest = trip.way.fastest(motor, trip.time_s - KEPT_S, trip.time_s + ahead_s)
        most = max(rpm, catch_up_rpm(fastest / COUNTS_S_PER_RPM))
        left = self._left(drive, target)
        needed = math.ceil(left / ahead_s / COUNTS_S_PER_RPM)
        if needed <= most:
            return target, max(rpm, needed)
        ahead = math.copysign(1.0, target - drive.course.place)
        nearer = round(target - ahead * (left - most * COUNTS_S_PER_RPM * ahead_s))
        if drive.moving and ahead * (nearer - drive.goal) < 0.0:
            nearer = drive.goal  # nobody is sent back
        return nearer, most

    def _left(self, drive: ObservedDrive, target: int) -> float:
        """Return how far a drive has to go to a target, by where it was read.

        Its orders may have been lost: then its course is there already.
        """
        way = target - drive.course.place
        lag = max(math.copysign(1.0, way) * drive.lag, 0.0)
        return abs(way) + (lag if lag > drive.bounds.rest else 0.0)

    def _has_news(self, drive: ObservedDrive, rpm: int) -> bool:
        """Tell whether a drive is told its speed: a new one, or to show that it obeys still."""
        shows_s = drive.course.ordered_s + SHOWS_PERIODS * self._wire.settings.segment_s
        return rpm * COUNTS_S_PER_RPM != drive.course.told or self._wire.now_s >= shows_s

    def _next(self, trip: Trip, motor: int, lead: Lead, share: float) -> tuple[int, int] | None:
        """Return a drive's next target and speed; None where it goes on as it is."""
        drive, period_s = self._wire.drives[motor], self._wire.settings.segment_s
        if not lead.way:
            return self._to_rest(drive, lead) if drive.moving else None
        until_s = min(trip.time_s + period_s, lead.until_s)
        here, there = trip.way.at(motor, trip.time_s), trip.way.at(motor, until_s)
        place = drive.course.place
        needed = lead.way * (there - place) / max(until_s - trip.time_s, period_s / 2.0)
        planned = abs(there - here) / max(until_s - trip.time_s, 1e-6) / COUNTS_S_PER_RPM
        most = catch_up_rpm(planned)
        if planned < SLOW_RPM:
            target = round(there)
            ahead = lead.way * (target - place) > 0.5
            rpm = _whole_rpm(math.ceil(needed / COUNTS_S_PER_RPM), most)
            return (target, rpm) if ahead else None
        rpm = _whole_rpm(round(needed / COUNTS_S_PER_RPM), most)
        speed, acc = rpm * COUNTS_S_PER_RPM, shared_acc(self._wire.settings.acceleration, share)
        brakes = speed**2 / (2.0 * slope_of(acc))  # or a gentle ramp would begin before its end
        sent = speed * (self._ahead_s(trip) - period_s / 2.0) + brakes
        room = min(lead.way * (lead.far - place), sent)
        return (round(place + lead.way * room), rpm) if room > 0.5 else None

    def _ahead_s(self, trip: Trip) -> float:
        return max(trip.ahead_s, 1.5 * self._wire.settings.segment_s)

    def _to_rest(self, drive: ObservedDrive, lead: Lead) -> tuple[int, int] | None:
        """Have a drive end where its motor stands for now, unless it has been sent there."""
        rest = round(lead.far)
        if drive.goal == rest:
            return None
        return rest, _whole_rpm(round(drive.course.told / COUNTS_S_PER_RPM), SPEED_MAX_RPM)

    def _last(self, trip: Trip, motor: int) -> tuple[int, int] | None:
        """Return the end of the motion, and the speed that has the drive there in time."""
        drive, way = self._wire.drives[motor], trip.way
        end = way.end[motor]
        if not drive.moving and drive.goal == end:
            return None
        left_s = max(way.end_s - trip.time_s, 1e-3)
        planned = abs(end - way.at(motor, trip.time_s)) / left_s / COUNTS_S_PER_RPM
        needed = math.ceil(abs(end - drive.course.place) / left_s / COUNTS_S_PER_RPM)
        return end, min(max(needed, LAST_RPM), catch_up_rpm(planned))


def way_from_here(wire: MksWire) -> Way:
    """Return a way that begins where the drives stand."""
    return Way(Motors(drive.goal for drive in wire.drives))


def ramp_to(course: Course, target: int, acc: int, share: float, kept: int = 0) -> int:
    """Return the ramp by which a drive goes to a target: its share, or what it needs to end there.

    A gentler one than that by which it came to its speed would have it run past its end, or than
    it brakes by (`kept`): its course may be there a moment earlier.
    """
    shared = max(shared_acc(acc, share), min(kept, acc))
    left = abs(target - course.place) - abs(course.speed) * HEEDED_S
    brakes = BRAKES_SURELY * course.speed**2 / (2.0 * max(left, 1.0))
    if not acc or brakes <= slope_of(shared):
        return shared
    needed = acc_of(brakes / COUNTS_S_PER_RPM)
    return min(needed + (slope_of(needed) < brakes), acc)


def beyond(drive: ObservedDrive, target: int) -> RequestRejected | None:
    """Refuse a target that a drive cannot be given."""
    if abs(target) <= TARGET_MAX:
        return None
    return RequestRejected(
        f"{drive} would turn to {target} counts, beyond the 512 turns that can be commanded: bring "
        "it near its zero and set that anew (`armdrive can setup`)",
        moved=False,
    )


def catch_up_rpm(planned: float) -> int:
    """Return the fastest speed that a drive is told where it lags, by the planned rpm."""
    return min(math.ceil(CATCH_UP * planned) + CATCH_UP_RPM, SPEED_MAX_RPM)


def _shares_of(speeds: Sequence[float]) -> list[float]:
    """Return each speed as a share of the fastest; 1 where nothing moves."""
    fastest = max(speeds)
    return [speed / fastest if fastest else 1.0 for speed in speeds]


def _whole_rpm(rpm: int, most: int) -> int:
    """Return a speed that a drive can be told: at least 1, and no more than so much."""
    return min(max(rpm, 1), most)
