"""The path planned for all motors, and the course that each drive's orders give it. Steps, seconds.

A `PlannedPath` is the requested motion: straight segments that join, on a time axis of their own.
A `Course` is what one drive makes of its orders: it turns towards its target by its ramp, no
faster than ordered.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from armdrive.dialects.bus.questions import REPLY_TIMEOUT_S
from armdrive.tasks import MoveBy
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class Interval:
    """The closed interval from `low` to `high`."""

    low: float
    high: float

    def __contains__(self, place: float) -> bool:
        return self.low <= place <= self.high

    def beyond(self, place: float) -> float:
        """Return the distance of a place from the interval; 0 inside it."""
        return max(self.low - place, place - self.high, 0.0)

    def nearest(self, place: float) -> float:
        """Return the place in the interval that is nearest to a place."""
        return min(max(place, self.low), self.high)

    def widened(self, by: float) -> Interval:
        """Return the interval with a margin added on either side."""
        return Interval(self.low - by, self.high + by)


@dataclass(frozen=True, slots=True)
class Segment:
    """One straight part of a path: when and where it begins and ends."""

    start_s: float
    end_s: float
    start: Motors
    end: Motors

    def at(self, motor: int, time_s: float) -> float:
        """Return a motor's place at a time, or at the nearer end of the segment."""
        if time_s >= self.end_s:
            return float(self.end[motor])
        share = max(time_s - self.start_s, 0.0) / (self.end_s - self.start_s)
        return self.start[motor] + share * (self.end[motor] - self.start[motor])


class PlannedPath:
    """The segments that are known and not yet passed. `end` is the end of the last one."""

    def __init__(self, start: Motors) -> None:
        self.end = start
        self.end_s = 0.0
        self._segments: deque[Segment] = deque()

    def append(self, move: MoveBy, from_s: float = 0.0) -> None:
        """Append a segment, which begins at `from_s` if the path has ended before."""
        start_s = max(self.end_s, from_s)
        end, end_s = self.end + move.steps, start_s + max(move.duration_s, 1e-6)
        self._segments.append(Segment(start_s, end_s, self.end, end))
        self.end, self.end_s = end, end_s

    def discard_before(self, time_s: float, kept_s: float) -> None:
        """Discard segments that ended more than `kept_s` before a time."""
        while len(self._segments) > 1 and self._segments[0].end_s <= time_s - kept_s:
            self._segments.popleft()

    def at(self, motor: int, time_s: float) -> float:
        """Return a motor's place at a time."""
        for segment in self._segments:
            if time_s < segment.end_s:
                return segment.at(motor, time_s)
        return float(self.end[motor])

    def averaged(self, time_s: float, window_s: float) -> list[float]:
        """Return every motor's mean place during the window that ends at a time.

        The same window for all motors keeps straight lines straight and turns jumps in speed into
        ramps.
        """
        motors = range(len(self.end))
        if not window_s:
            return [self.at(motor, time_s) for motor in motors]
        totals, at_s = [0.0] * len(self.end), time_s - window_s
        for segment in self._segments:
            if segment.start_s >= time_s:
                break
            if segment.end_s <= at_s:
                continue
            begin_s, end_s = max(segment.start_s, at_s), min(segment.end_s, time_s)
            for motor in motors:
                # it stood still before the segment, and turns evenly during it
                totals[motor] += (begin_s - at_s) * segment.start[motor]
                ends = segment.at(motor, begin_s) + segment.at(motor, end_s)
                totals[motor] += (end_s - begin_s) * ends / 2.0
            at_s = end_s
        if at_s < time_s:
            for motor in motors:
                totals[motor] += (time_s - at_s) * self.at(motor, time_s)
        return [total / window_s for total in totals]


class SegmentFeed:
    """Fetches a motion's segments and appends them to its path."""

    def __init__(self, path: PlannedPath, segments: Iterator[MoveBy]) -> None:
        self._path, self._segments = path, segments
        self.exhausted = False
        """Whether the last segment has been fetched."""
        self.underruns = 0
        """How often the path ended although more segments were to come."""
        self.latest_s = 0.0
        """The duration of the latest segment."""

    def fetch(self, has_room: Callable[[], bool], from_s: float, *, dry: bool) -> None:
        """Fetch segments while there is room; a path that ran `dry` continues at `from_s`."""
        while not self.exhausted and has_room():
            segment = next(self._segments, None)
            if segment is None:
                self.exhausted = True
                return
            self._path.append(segment, from_s)
            self.latest_s = segment.duration_s
            self.underruns, dry = self.underruns + dry, False


# Step width of the course.
STEP_S = 0.005
# How much of a course is kept: no reading is older.
PAST_S = 1.0
# How far a course is moved towards a reading, as a share of their distance: half in two looks.
CORRECTION_GAIN = 0.3


class Order(NamedTuple):
    """A drive's target, and how fast the order lets it turn up and down."""

    sent_s: float
    goal: float
    up: float
    down: float


@dataclass(frozen=True, slots=True)
class OrdersInForce:
    """The targets that a drive may be turning to, and its greatest speeds up and down."""

    goals: Interval
    up: float
    down: float

    @property
    def fastest(self) -> float:
        """Its greatest speed in either direction."""
        return max(self.up, self.down)


class Course:
    """Where one drive is, and recently was, if it obeys each order at once.

    The observer allows for delays when it compares the course with readings. With an infinite
    speed the drive is at its target at once, with an infinite slope at its full speed.
    """

    def __init__(self) -> None:
        self.place = 0.0
        self.speed = 0.0
        self.goal = 0.0
        self.max_speed = 0.0
        """The speed of its last order."""
        self.slope = math.inf
        self._at_s = -math.inf
        self._past: deque[tuple[float, float]] = deque()
        self._orders: deque[Order] = deque()

    def rest_at(self, place: float, now_s: float) -> None:
        """Record that the drive stands at a place."""
        self.goal, self.max_speed = place, 0.0
        self._orders = deque((Order(now_s, place, 0.0, 0.0),))
        self.put(place, 0.0, now_s)

    def put(self, place: float, speed: float, now_s: float) -> None:
        """Move the course to a place; the orders stay."""
        self.place, self.speed, self._at_s = place, speed, now_s
        self._past = deque(((now_s, place),))

    def order(self, goal: float, speed: float, slope: float, now_s: float) -> None:
        """Record an order."""
        self.advance(now_s)
        self.goal, self.max_speed, self.slope = goal, speed, slope
        up = speed if goal > self.place else 0.0
        down = speed if goal < self.place else 0.0
        self._orders.append(Order(now_s, goal, max(up, self.speed), max(down, -self.speed)))
        while len(self._orders) > 1 and self._orders[1].sent_s < now_s - 2.0 * PAST_S:
            self._orders.popleft()

    def advance(self, now_s: float) -> None:
        """Advance the course to the present."""
        if now_s <= self._at_s:
            return
        if math.isinf(self.max_speed) or math.isinf(self._at_s):
            self.place = self.goal if self.max_speed else self.place
            self._at_s = now_s
        while self._at_s < now_s and not (self.place == self.goal and not self.speed):
            step_s = min(STEP_S, now_s - self._at_s)
            self._go(step_s)
            self._at_s = max(self._at_s + step_s, math.nextafter(self._at_s, math.inf))
            self._past.append((self._at_s, self.place))
        self._at_s = now_s
        past = self._past
        if len(past) > 1 and past[-1][1] == past[-2][1] == self.place:
            past.pop()  # it stands: both ends of that time tell as much
        past.append((now_s, self.place))
        while self._past[0][0] < now_s - PAST_S:
            self._past.popleft()

    def _go(self, step_s: float) -> None:
        """Advance by one step, at a speed from which the ramp still ends at the target."""
        left = self.goal - self.place
        if math.isinf(self.slope):
            self.place += math.copysign(min(self.max_speed * step_s, abs(left)), left)
            self.speed = math.copysign(self.max_speed, left) if self.place != self.goal else 0.0
            return
        # The new speed v covers this step, at the mean of both speeds, and then brakes on the ramp:
        # (speed + v) * step / 2 + v^2 / (2 * slope) = left. Solved for v, that is `fastest`.
        sign = math.copysign(1.0, left)
        change = self.slope * step_s
        room = 2.0 * self.slope * max(abs(left) - sign * self.speed * step_s / 2.0, 0.0)
        fastest = math.sqrt(change**2 / 4.0 + room) - change / 2.0
        wanted = sign * min(self.max_speed, fastest)
        speed = self.speed + min(max(wanted - self.speed, -change), change)
        self.place += (self.speed + speed) / 2.0 * step_s
        self.speed = speed
        # within half a count, steps of this width would swing around the target for ever
        if abs(self.goal - self.place) < 0.5 and abs(speed) <= change:
            self.place, self.speed = self.goal, 0.0

    def correct(self, by: float) -> None:
        """Shift the course towards a reading."""
        self.place += by

    def off(self, place: float, from_s: float) -> float:
        """Return how far a place is outside the course since a moment; negative if it is below.

        A drive that follows its orders was there lately, which ends the search early.
        """
        low = high = self._past[-1][1] if self._past else self.place
        for at_s, passed in reversed(self._past):
            if passed < low:
                low = passed
            elif passed > high:
                high = passed
            if low <= place <= high:
                return 0.0
            if at_s < from_s:
                break
        return place - low if place < low else max(place - high, 0.0)

    def hull(self, from_s: float) -> Interval:
        """Return the range of places from a moment to the present."""
        places = []
        for at_s, place in reversed(self._past):
            places.append(place)
            if at_s < from_s:
                break
        places = places or [self.place]
        return Interval(min(places), max(places))

    def in_force(self, from_s: float) -> OrdersInForce:
        """Return what the orders allow that the drive may have obeyed since a moment.

        An order is in force until `REPLY_TIMEOUT_S` after its successor was sent.
        """
        found, replaced_s = list[Order](), math.inf
        for order in reversed(self._orders):
            if replaced_s <= from_s - REPLY_TIMEOUT_S:
                break
            found.append(order)
            replaced_s = order.sent_s
        goals = [order.goal for order in found] or [self.goal]
        up = max((order.up for order in found), default=0.0)
        down = max((order.down for order in found), default=0.0)
        return OrdersInForce(Interval(min(goals), max(goals)), up, down)

    @property
    def ordered_s(self) -> float:
        """When the last order was sent."""
        return self._orders[-1].sent_s if self._orders else -math.inf

    def braking(self, speed: float) -> float:
        """Return the braking distance from a speed, by the ramp of the last order."""
        return 0.0 if math.isinf(self.slope) else speed**2 / (2.0 * self.slope)


class Courses:
    """Where one drive is by its orders, in two ways, since nothing tells how late it obeys each.

    If it obeys all orders equally late, it is on its course `ordered`, some time ago. If each is
    late by a time of its own, it leaves that course, but stays near the one that its readings move.
    """

    def __init__(self) -> None:
        self.likely = Course()
        """Where it probably is: where its orders have it, moved towards its readings."""
        self.ordered = Course()
        """Where its orders have it; moved only as far as no delay within the bound explains."""
        self._both = (self.likely, self.ordered)

    def order(self, goal: float, speed: float, slope: float, now_s: float) -> None:
        """Record an order."""
        for course in self._both:
            course.order(goal, speed, slope, now_s)

    def rest_at(self, place: float, now_s: float) -> None:
        """Record that the drive stands at a place."""
        for course in self._both:
            course.rest_at(place, now_s)

    def advance(self, now_s: float) -> None:
        """Advance both to the present."""
        for course in self._both:
            course.advance(now_s)

    def off(self, place: float, from_s: float) -> float:
        """Return how far a place is off the nearer one since a moment."""
        return min(abs(course.off(place, from_s)) for course in self._both)

    def hull(self, from_s: float) -> Interval:
        """Return the range of the places of both from a moment to the present."""
        hulls = [course.hull(from_s) for course in self._both]
        return Interval(min(each.low for each in hulls), max(each.high for each in hulls))

    def correct(self, place: float, asked_s: float, ordered_from_s: float) -> None:
        """Move both towards a reading, which was asked for at `asked_s`.

        Orders since `ordered_from_s` may have had the drive there: that much explains the delay.
        """
        self.likely.correct(CORRECTION_GAIN * self.likely.off(place, asked_s))
        self.ordered.correct(CORRECTION_GAIN * self.ordered.off(place, ordered_from_s))
