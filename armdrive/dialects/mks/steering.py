"""Steer MKS drives along a path: each gets new targets while it moves.

At a fixed period every moving motor gets the speed that brings it, by the end of the period, to
where the path is then. Its target lies as far ahead as the motor turns in one direction: too far to
reach before the next order, but within the announced time if no order follows. So drives do not
brake between segments, and stop by themselves if their host dies. Speeds are whole rpm; the
rounding error is part of the next period's distance, so it does not add up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.dialects.bus.intervals import CONFIRMING_LOOKS, MAX_DELAY_S, DriveFinding
from armdrive.dialects.bus.paths import SegmentFeed
from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.exchange import MksExchange
from armdrive.dialects.mks.observer import Verdict
from armdrive.dialects.mks.paths import KEPT_S, Heading, SteeredPath
from armdrive.dialects.mks.stops import ramp_to, rpm_within, shared_acc
from armdrive.tasks import MoveAlong, RequestRejected
from firmware_protocol.mks import (
    COUNTS_S_PER_RPM,
    SPEED_MAX_RPM,
    TARGET_MAX,
    MoveAbsoluteAxis,
    slope_of,
)
from kinematics.spaces import Motors

# Below this speed, a drive's target is only the end of the period, where it stands.
SLOW_RPM = MIN_FINAL_RPM = 3
# Below this speed, or if it is behind, a drive's speed is chosen so that it arrives in time.
CREEP_RPM = 32
# How much faster than planned a drive that is behind may turn: its joint may be planned at its
# limit, coupled motors may add twice as much, and 1 rpm is the rounding error of a slow drive.
CATCH_UP, CATCH_UP_RPM = 1.1, 1
# While a drive is behind the others, the path goes on at half its speed, and the drive at four
# fifths of its own at most. So it comes nearer, and a joint that two motors turn by equal shares is
# no faster than planned: neither while the drive waits where its path comes back, nor as it catches
# up.
APART_RATE, APART_CATCH_UP = 0.5, 0.8
# Drives are apart if no single time offset explains all positions within this share of what still
# counts as on the path. On a link whose delays are equal, or vary by up to 0.04 s, they never are.
APART_SHARE = 0.2
# An unchanged order is repeated after this many periods, so that a drive can reject it.
REFRESH_PERIODS = 1.5


class ContourCheck:
    """Compares where all drives are with their common path: one that lags leads the arm off it.

    The observer judges each drive by its own orders. That is not enough: each may be within its
    corridor, one early and another late, and the arm between two points of its path in no place
    that was planned. And a weak drive that is steered from where it was read is never far from its
    orders. So here all positions of one look are compared with the path: is there a moment at which
    all would be where they are?
    """

    def __init__(self, drives: Sequence[MksDrive], path: SteeredPath) -> None:
        self._drives, self._path = drives, path
        self.apart = False
        """Whether a drive was behind the others at the last look."""
        self._looks_off_path = 0

    def compare(self, asked_at_s: float, period_s: float, now_s: float) -> Verdict | None:
        """Compare the positions of all drives at one look with their path.

        `asked_at_s` is the path time of that look. Drives that all lag by the same time are on
        the path, only later.
        """
        path, counts = self._path, [drive.count for drive in self._drives]
        margins = [drive.margin(now_s) for drive in self._drives]
        late_s = min(asked_at_s + period_s, path.end_s)
        early_s, near = max(late_s - KEPT_S, 0.0), [APART_SHARE * each for each in margins]
        self.apart = not path.explains(counts, near, early_s, late_s)
        if not self.apart or path.explains(counts, margins, early_s, late_s):
            self._looks_off_path = 0
            return None
        self._looks_off_path += 1
        if self._looks_off_path < CONFIRMING_LOOKS:
            return None
        worst = max(
            range(len(counts)),
            key=lambda motor: abs(path.at(motor, late_s) - counts[motor]) / margins[motor],
        )
        drive = self._drives[worst]
        return Verdict(drive, DriveFinding.OFF_PATH, drive.count, path.at(worst, late_s))


class Trip:
    """One motion under way: the source of its segments, and its progress."""

    def __init__(self, request: MoveAlong, drives: Sequence[MksDrive], period_s: float) -> None:
        self.path = path = SteeredPath(Motors(drive.goal for drive in drives))
        """The path of all drives, from where they stand."""
        self.contour = ContourCheck(drives, path)
        self.ahead_s = request.ahead_s
        self.held_back = request.held_back
        """Whether the arm is paused."""
        self.time_s = 0.0
        """The path time at which the motors are now."""
        self.sent_s = 0.0
        """The path time of their last targets."""
        self.due_s = -math.inf
        """When the next orders are due."""
        self.ending = False
        """Whether no more segments will be fetched, at the end or during a pause."""
        self.sent_all = False
        """Whether the final targets have been sent."""
        self.rate = 1.0
        """How fast the path goes on: less than 1 while a drive is behind the others."""
        self._period_s = period_s
        self._feed = SegmentFeed(path, request.segments)
        self._resumed = 0
        self._steered_s = -math.inf

    @property
    def underruns(self) -> int:
        """How often drives stood still although more of their motion was to come."""
        return self._feed.underruns + self._resumed

    def at_s(self, now_s: float) -> float:
        """Return the path time at which the motors should be now."""
        since_s = now_s - self._steered_s if math.isfinite(self._steered_s) else 0.0
        return min(self.time_s + self.rate * since_s, self.sent_s)

    def advance(self, now_s: float) -> None:
        """Advance by the time since the last orders, then fetch the segments that fit.

        Late periods do not add up. If the drives are apart, the path goes on more slowly, but not
        in a pause, which has to end in time.
        """
        # half a period at most is made up for, so orders never come in a rush after a delay
        self.due_s = max(self.due_s, now_s - self._period_s / 2.0) + self._period_s
        self.time_s, self._steered_s = self.at_s(now_s), now_s
        self.path.discard_before(self.time_s, KEPT_S)
        held = self.held_back()
        self.rate = APART_RATE if self.contour.apart and not held else 1.0
        if not held:
            dry = self.time_s >= self.path.end_s > 0.0
            self._feed.fetch(self._has_room, self.time_s, dry=dry)
        self.ending = self._feed.exhausted or held

    def _has_room(self) -> bool:
        left_s = self.path.end_s - self.time_s
        return left_s <= 0.0 or left_s + self._feed.latest_s <= self.ahead_s + 1e-6

    def most_rpm(self, planned: float) -> int:
        """Return the greatest speed of a drive that may be behind, from its planned rpm."""
        if self.rate < 1.0:
            return max(math.ceil(APART_CATCH_UP * planned), 1)
        return catch_up_rpm(planned)

    def resume(self, time_s: float, now_s: float) -> None:
        """Continue from the path time at which the motors were found."""
        self.time_s = self.sent_s = time_s
        self._steered_s = self.due_s = now_s
        self.sent_all = False
        self._resumed += 1


class Steering:
    """Sends the drives their orders along a trip."""

    def __init__(self, io: MksExchange, trip: Trip) -> None:
        self._io, self.trip = io, trip
        self.refused: RequestRejected | None = None
        """Why a target cannot be commanded."""

    def steer(self) -> None:
        """Send every moving drive its next order, unless one of them may have restarted.

        It would turn there from its new zero. Without orders, all end at their last targets.
        """
        io, trip, period_s = self._io, self.trip, self._io.settings.segment_s
        trip.advance(io.now_s)
        if any(drive.may_have_restarted(io.now_s) for drive in io.drives):
            return
        ahead_s = min(trip.time_s + trip.ahead_s, trip.path.end_s)
        trip.sent_s = ahead_s
        last = trip.ending and trip.time_s + trip.rate * period_s >= trip.path.end_s - 1e-9
        motors = range(len(io.drives))
        headings = [trip.path.heading(motor, trip.time_s, ahead_s) for motor in motors]
        shares = _shares_of([heading.speed for heading in headings])
        for motor, (drive, heading) in enumerate(zip(io.drives, headings, strict=True)):
            drive.course.advance(io.now_s)
            share = shares[motor]
            order = self._last(motor) if last else self._next(motor, heading, share)
            if order is None:
                continue
            target, rpm = order
            # These may be farther from their target than their course says, or too slow for it.
            # Each gets a speed, or a nearer target, that it reaches in the announced time.
            if last or trip.contour.apart or rpm < CREEP_RPM or self._is_unconfirmed(drive):
                target, rpm = self._in_time(motor, target, rpm)
            if (refused := beyond(drive, target)) is not None:
                self.refused = refused
                return
            if target != drive.goal or (drive.moving and self._has_news(drive, rpm)):
                self._send(drive, target, rpm, share)
        if last:
            trip.time_s = trip.sent_s = trip.path.end_s
            ends = zip(io.drives, trip.path.end, strict=True)
            trip.sent_all = all(drive.goal == end for drive, end in ends)

    def _send(self, drive: MksDrive, target: int, rpm: int, share: float) -> None:
        most = self._io.settings.acceleration
        again = drive.moving and target == drive.goal
        kept = drive.last_order.acc if again and drive.last_order is not None else 0
        acc = ramp_to(drive.course, target, most, share, kept)
        self._io.send(drive, MoveAbsoluteAxis(target, rpm, acc))

    def _in_time(self, motor: int, target: int, rpm: int) -> tuple[int, int]:
        """Return a target and speed that a drive reaches in the announced time, by its reading.

        It turns no faster than the path did within the last second. If that is not enough, its
        target is nearer and the motion takes longer.
        """
        drive, trip, ahead_s = self._io.drives[motor], self.trip, self._ahead_s
        fastest = trip.path.fastest(motor, trip.time_s - KEPT_S, trip.time_s + ahead_s)
        most = max(rpm, trip.most_rpm(fastest / COUNTS_S_PER_RPM))
        left = self._left(drive, target)
        if rpm_within(left, ahead_s) <= most:
            return target, max(rpm, min(rpm_within(left, self._left_s), most))
        ahead = math.copysign(1.0, target - drive.course.place)
        nearer = round(target - ahead * (left - most * COUNTS_S_PER_RPM * ahead_s))
        read_s = self._io.now_s - drive.asked_s  # it may have moved as fast as that since
        brakes_s = most * COUNTS_S_PER_RPM / slope_of(self._io.settings.acceleration)
        reverses = drive.moving and ahead * (nearer - drive.goal) < 0.0
        if reverses and read_s + brakes_s > ahead_s:  # turning back would take longer than going on
            nearer = drive.goal
        return nearer, most

    def _left(self, drive: MksDrive, target: int) -> float:
        """Return the distance to a target from where a drive may still be.

        Its course may be ahead of the drive, because orders were lost.
        """
        distance = target - drive.course.place
        lag = drive.lag
        if self._is_unconfirmed(drive):
            lag = drive.course.place - drive.count
        lag = max(math.copysign(1.0, distance) * lag, 0.0)
        return abs(distance) + (lag if lag > drive.bounds.rest else 0.0)

    def _is_unconfirmed(self, drive: MksDrive) -> bool:
        """Return whether a drive replies, but has confirmed no order for a while.

        Then its orders were lost, and it may still be where it was read last. A drive that does not
        reply at all may well move on, so it is taken to do that until it is found to be mute.
        """
        confirmed_s = max(drive.asked_s, drive.confirmed_s)
        return drive.moving and drive.ledger.replied_s > confirmed_s + MAX_DELAY_S

    def _has_news(self, drive: MksDrive, rpm: int) -> bool:
        """Return whether a drive needs an order: a new speed, or a refresh that it may reject."""
        refresh_s = drive.course.ordered_s + REFRESH_PERIODS * self._io.settings.segment_s
        return rpm * COUNTS_S_PER_RPM != drive.course.max_speed or self._io.now_s >= refresh_s

    def _next(self, motor: int, heading: Heading, share: float) -> tuple[int, int] | None:
        """Return a drive's next target and speed; None if its present order still fits."""
        drive, trip, period_s = self._io.drives[motor], self.trip, self._io.settings.segment_s
        if not heading.direction:
            return self._to_rest(drive, heading) if drive.moving else None
        until_s = min(trip.time_s + trip.rate * period_s, heading.until_s)
        here, there = trip.path.at(motor, trip.time_s), trip.path.at(motor, until_s)
        place = drive.course.place
        lasts_s = (until_s - trip.time_s) / trip.rate
        needed = heading.direction * (there - place) / max(lasts_s, period_s / 2.0)
        planned = abs(there - here) / max(until_s - trip.time_s, 1e-6) / COUNTS_S_PER_RPM
        most = trip.most_rpm(planned)
        if planned < SLOW_RPM:  # whole rpm are too coarse: it goes there and waits for the others
            target = round(there)
            ahead = heading.direction * (target - place) > 0.5
            rpm = _whole_rpm(math.ceil(needed / COUNTS_S_PER_RPM), most)
            return (target, rpm) if ahead else None
        rpm = _whole_rpm(round(needed / COUNTS_S_PER_RPM), most)
        speed, acc = rpm * COUNTS_S_PER_RPM, shared_acc(self._io.settings.acceleration, share)
        brakes = speed**2 / (2.0 * slope_of(acc))  # else a gentle ramp would begin too early
        sent = speed * (self._ahead_s - period_s / 2.0) + brakes
        room = min(heading.direction * (heading.end - place), sent)
        return (round(place + heading.direction * room), rpm) if room > 0.5 else None

    @property
    def _ahead_s(self) -> float:
        """How long a drive turns at most if no further order reaches it."""
        return max(self.trip.ahead_s, 1.5 * self._io.settings.segment_s)

    @property
    def _left_s(self) -> float:
        """How long a drive that is behind may take to its target.

        Where the path ends, that is until its end: a pause is over when the others stand there.
        """
        trip = self.trip
        left_s = trip.path.end_s - trip.time_s if trip.ending else math.inf
        return max(min(trip.ahead_s, left_s), 1.5 * self._io.settings.segment_s)

    def _to_rest(self, drive: MksDrive, heading: Heading) -> tuple[int, int] | None:
        """Return the order that ends at a standing motor's place; None if that is the target."""
        rest = round(heading.end)
        if drive.goal == rest:
            return None
        return rest, _whole_rpm(round(drive.course.max_speed / COUNTS_S_PER_RPM), SPEED_MAX_RPM)

    def _last(self, motor: int) -> tuple[int, int] | None:
        """Return the end of the motion, and the speed that reaches it in time."""
        drive, trip, path = self._io.drives[motor], self.trip, self.trip.path
        end = path.end[motor]
        if not drive.moving and drive.goal == end:
            return None
        left_s = max(path.end_s - trip.time_s, 1e-3)
        planned = abs(end - path.at(motor, trip.time_s)) / left_s / COUNTS_S_PER_RPM
        needed = rpm_within(abs(end - drive.course.place), left_s)
        return end, min(max(needed, MIN_FINAL_RPM), trip.most_rpm(planned))


def beyond(drive: MksDrive, target: int) -> RequestRejected | None:
    """Return why a drive cannot take a target; None if it can."""
    if abs(target) <= TARGET_MAX:
        return None
    return RequestRejected(
        f"{drive} would turn to {target} counts, beyond the 512 turns that can be commanded: bring "
        "it near its zero and set a new zero (`armdrive can setup`)",
        moved=False,
    )


def catch_up_rpm(planned: float) -> int:
    """Return the greatest speed of a drive that lags, from its planned rpm."""
    return min(math.ceil(CATCH_UP * planned) + CATCH_UP_RPM, SPEED_MAX_RPM)


def catch_up_travel(time_s: float, rate_hz: float, corridor: float) -> tuple[float, float]:
    """Return how much of its planned motion a drive makes in a time, and the counts on top.

    A drive that lags turns faster, but makes up for no more than it may lag: whichever is less.
    """
    extra_hz = (CATCH_UP - 1.0) * rate_hz + CATCH_UP_RPM * COUNTS_S_PER_RPM
    faster = time_s, extra_hz * time_s
    made_up = time_s + MAX_DELAY_S, corridor
    return min(faster, made_up, key=lambda travel: travel[0] * rate_hz + travel[1])


def _shares_of(speeds: Sequence[float]) -> list[float]:
    """Return each speed as a share of the greatest; 1 if nothing moves."""
    fastest = max(speeds)
    return [speed / fastest if fastest else 1.0 for speed in speeds]


def _whole_rpm(rpm: int, most: int) -> int:
    """Return a speed in bounds: from 1 to `most` rpm."""
    return min(max(rpm, 1), most)
