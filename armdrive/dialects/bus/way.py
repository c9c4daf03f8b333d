"""Where the drives of an arm shall be, and where each is by its orders. Steps, seconds.

A `Way` is the motion that was asked for: straight segments that join, on a time of their own. A
`Course` is what one drive makes of its orders: it turns towards its goal, no faster than it was
told and by its ramp.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.tasks import MoveBy
from kinematics.spaces import Motors

KEPT_S = 1.0
"""What lies behind is remembered for so long: drives may be found to be there still."""
COARSE_S, FINE_S = 0.01, 0.001
"""How finely a place on the way is looked for, at first and at last."""


@dataclass(frozen=True, slots=True)
class Interval:
    """From `low` to `high`, both of them in it."""

    low: float
    high: float

    def __contains__(self, place: float) -> bool:
        return self.low <= place <= self.high

    def beyond(self, place: float) -> float:
        """Return how far a place is outside; 0 for one that is not."""
        return max(self.low - place, place - self.high, 0.0)

    def widened(self, by: float) -> Interval:
        """Return it with so much more on either side."""
        return Interval(self.low - by, self.high + by)


@dataclass(frozen=True, slots=True)
class Segment:
    """One straight part of a way: when and where it begins and ends."""

    start_s: float
    end_s: float
    start: Motors
    end: Motors

    def at(self, motor: int, time_s: float) -> float:
        """Return where a motor is on it, or at the nearer of its ends."""
        if time_s >= self.end_s:
            return float(self.end[motor])
        share = max(time_s - self.start_s, 0.0) / (self.end_s - self.start_s)
        return self.start[motor] + share * (self.end[motor] - self.start[motor])


@dataclass(frozen=True, slots=True)
class Lead:
    """How a motor goes on: which way (0 where it stands), how far before it turns, until when."""

    way: int
    far: float
    until_s: float


class Way:
    """The segments that were drawn and not passed. Its end is as far as anything was drawn."""

    def __init__(self, start: Motors) -> None:
        self.end = start
        self.end_s = 0.0
        self._segments: deque[Segment] = deque()

    def draw(self, move: MoveBy, from_s: float = 0.0) -> None:
        """Take in the next segment; where all of it was passed by then, it begins at a time."""
        start_s = max(self.end_s, from_s)
        end, end_s = self.end + move.steps, start_s + max(move.duration_s, 1e-6)
        self._segments.append(Segment(start_s, end_s, self.end, end))
        self.end, self.end_s = end, end_s

    def pass_by(self, time_s: float, kept_s: float = KEPT_S) -> None:
        """Forget what lies farther behind than what is kept."""
        while len(self._segments) > 1 and self._segments[0].end_s <= time_s - kept_s:
            self._segments.popleft()

    def at(self, motor: int, time_s: float) -> float:
        """Return where a motor shall be at a time."""
        for segment in self._segments:
            if time_s < segment.end_s:
                return segment.at(motor, time_s)
        return float(self.end[motor])

    def averaged(self, motor: int, time_s: float, window_s: float) -> float:
        """Return the mean of where a motor shall be over so long a time before this one.

        The same window for all motors keeps straight what is straight, and where speeds jump it
        makes ramps.
        """
        if not window_s:
            return self.at(motor, time_s)
        total, at_s = 0.0, time_s - window_s
        for segment in self._segments:
            if segment.start_s >= time_s:
                break
            if segment.end_s <= at_s:
                continue
            if segment.start_s > at_s:  # it stood before
                total += (segment.start_s - at_s) * segment.start[motor]
                at_s = segment.start_s
            until_s = min(segment.end_s, time_s)
            ends = segment.at(motor, at_s) + segment.at(motor, until_s)
            total += (until_s - at_s) * ends / 2.0
            at_s = until_s
        if at_s < time_s:
            total += (time_s - at_s) * self.at(motor, time_s)
        return total / window_s

    def span(self, motor: int, early_s: float, late_s: float) -> Interval:
        """Return from where to where a motor goes between two times."""
        ends = [each.end[motor] for each in self._segments if early_s < each.end_s < late_s]
        places = (self.at(motor, early_s), self.at(motor, late_s), *ends)
        return Interval(min(places), max(places))

    def nearest_s(self, counts: Sequence[int], early_s: float, late_s: float) -> float:
        """Return when between two times motors should be where they were found, or nearest to it.

        The earliest such time: what is driven twice is not left out.
        """
        for step_s in (COARSE_S, FINE_S):
            steps = max(math.ceil((late_s - early_s) / step_s), 1)
            times = [min(early_s + step * step_s, late_s) for step in range(steps + 1)]
            found_s = min(times, key=lambda time_s: self._off(counts, time_s))
            early_s, late_s = max(found_s - step_s, early_s), min(found_s + step_s, late_s)
        return found_s

    def passes(
        self, counts: Sequence[int], margins: Sequence[float], early_s: float, late_s: float
    ) -> bool:
        """Tell whether at one and the same time all motors should be where they were found."""
        time_s = late_s
        while time_s > early_s - COARSE_S:
            at_s = max(time_s, early_s)
            found = enumerate(zip(counts, margins, strict=True))
            if all(abs(self.at(motor, at_s) - count) <= most for motor, (count, most) in found):
                return True
            time_s -= COARSE_S
        return False

    def _off(self, counts: Sequence[int], time_s: float) -> float:
        return max(abs(self.at(motor, time_s) - count) for motor, count in enumerate(counts))

    def lead(self, motor: int, from_s: float, until_s: float) -> Lead:
        """Return how a motor goes on from a time: no further than it goes one way."""
        way, far, far_s = 0, self.at(motor, from_s), from_s
        for segment in self._segments:
            if segment.end_s <= from_s:
                continue
            if segment.start_s >= until_s:
                break
            turn = segment.end[motor] - segment.start[motor]
            if turn * way < 0:
                break
            if turn:
                way = 1 if turn > 0 else -1
                far_s = min(segment.end_s, until_s)
                far = segment.at(motor, far_s)
        return Lead(way, far, far_s)

    def fastest(self, motor: int, from_s: float, until_s: float) -> float:
        """Return how fast a motor goes at most between two times."""
        ways = (
            abs(each.end[motor] - each.start[motor]) / (each.end_s - each.start_s)
            for each in self._segments
            if each.end_s > from_s and each.start_s < until_s
        )
        return max(ways, default=0.0)

    def speed(self, motor: int, from_s: float, lead: Lead) -> float:
        """Return how fast a motor goes on a lead, at a mean."""
        way = abs(lead.far - self.at(motor, from_s))
        return way / (lead.until_s - from_s) if way else 0.0


STEP_S = 0.005
"""A course goes on in steps of this length."""
PAST_S = 1.0
"""So much of a course is kept: no reading is of an earlier moment."""


@dataclass(frozen=True, slots=True)
class Order:
    """A goal that a drive was sent to, and how fast that lets it turn up and down."""

    sent_s: float
    goal: float
    up: float
    down: float


class Course:
    """Where one drive is by its orders, and where it was by them a while ago.

    Every order is taken to be obeyed at once: that none is, or comes late, is for those who compare
    it with readings. An infinite speed or slope has the drive at its goal, or its speed, at once.
    """

    def __init__(self) -> None:
        self.place = 0.0
        self.speed = 0.0
        self.goal = 0.0
        self.told = 0.0
        """How fast it may turn by its last order."""
        self.slope = math.inf
        self._at_s = -math.inf
        self._past: deque[tuple[float, float]] = deque()
        self._orders: deque[Order] = deque()

    def rest_at(self, place: float, now_s: float) -> None:
        """Take it for standing at a place."""
        self.goal, self.told = place, 0.0
        self._orders = deque((Order(now_s, place, 0.0, 0.0),))
        self.put(place, 0.0, now_s)

    def put(self, place: float, speed: float, now_s: float) -> None:
        """Take it for being at a place, whatever its orders made of it; they stay."""
        self.place, self.speed, self._at_s = place, speed, now_s
        self._past = deque(((now_s, place),))

    def order(self, goal: float, speed: float, slope: float, now_s: float) -> None:
        """Send it to a goal."""
        self.advance(now_s)
        self.goal, self.told, self.slope = goal, speed, slope
        up, down = (speed if way * (goal - self.place) > 0.0 else 0.0 for way in (1, -1))
        order = Order(now_s, goal, max(up, self.speed), max(down, -self.speed))
        self._orders.append(order)
        while len(self._orders) > 1 and self._orders[1].sent_s < now_s - 2.0 * PAST_S:
            self._orders.popleft()

    def advance(self, now_s: float) -> None:
        """Let it go on until now."""
        if now_s <= self._at_s:
            return
        if math.isinf(self.told) or math.isinf(self._at_s):
            self.place = self.goal if self.told else self.place
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
        """Go on by one step: so fast that it can still end at its goal by its ramp."""
        left = self.goal - self.place
        if math.isinf(self.slope):
            way = min(self.told * step_s, abs(left))
            self.place += math.copysign(way, left)
            self.speed = math.copysign(self.told, left) if self.place != self.goal else 0.0
            return
        way = math.copysign(1.0, left)
        change = self.slope * step_s
        room = 2.0 * self.slope * max(abs(left) - way * self.speed * step_s / 2.0, 0.0)
        fastest = math.sqrt(change**2 / 4.0 + room) - change / 2.0
        wanted = way * min(self.told, fastest)
        speed = self.speed + min(max(wanted - self.speed, -change), change)
        self.place += (self.speed + speed) / 2.0 * step_s
        self.speed = speed
        if abs(self.goal - self.place) < 0.5 and abs(speed) <= change:
            self.place, self.speed = self.goal, 0.0

    def draw(self, by: float) -> None:
        """Bring it nearer to where the drive was read."""
        self.place += by

    def hull(self, from_s: float, to_s: float) -> Interval:
        """Return from where to where it went between two moments."""
        places = []
        for at_s, place in reversed(self._past):
            if at_s <= to_s:
                places.append(place)
            if at_s < from_s:
                break
        return Interval(min(places), max(places)) if places else Interval(self.place, self.place)

    def in_force(self, from_s: float, late_s: float) -> tuple[Order, ...]:
        """Return what it may have obeyed since a moment, if orders can be so late."""
        found, replaced_s = [], math.inf
        for order in reversed(self._orders):
            if replaced_s <= from_s - late_s:
                break
            found.append(order)
            replaced_s = order.sent_s
        return tuple(reversed(found))

    @property
    def ordered_s(self) -> float:
        """When it was sent anywhere last."""
        return self._orders[-1].sent_s if self._orders else -math.inf

    @property
    def brakes(self) -> float:
        """How far it turns until it stands, by its ramp."""
        return 0.0 if math.isinf(self.slope) else self.speed**2 / (2.0 * self.slope)


# How long a way takes from rest to rest, by ramps.


def trapezoid_s(way: float, speed: float, slope: float) -> float:
    """Return how long a way takes from rest to rest, at most this fast, by ramps of a slope."""
    if not way:
        return 0.0
    if math.isinf(slope):
        return way / speed
    peak = min(speed, math.sqrt(way * slope))
    return way / peak + peak / slope if peak >= speed else 2.0 * way / peak
