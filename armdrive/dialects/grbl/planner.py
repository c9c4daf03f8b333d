"""How a GRBL board drives lines: its planner's times, its segment buffer, and how it stops."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import MappingProxyType

from armdrive.abilities import segment_s
from armdrive.dialects.controller import StopPart, Stopping
from armdrive.tasks import MoveBy
from firmware_protocol.grbl import Variant
from kinematics.spaces import Motors

# How long a board's planner takes for queued lines: trapezoids, and corners passed in motion.
#
# Units are the board's own ("mm"), seconds. Source of the corner's speed and of the two passes:
# gnea/grbl grbl/planner.c (plan_buffer_line, planner_recalculate).

STRAIGHT = 1e-6
"""A cosine so near to 1 or -1 is a turn right round, or none."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the axes of the motors can do: steps a unit, units a second, units a second squared.

    `junction` is how far a corner may be cut in thought ($11), in units.
    """

    steps_per_unit: tuple[float, ...]
    rates: tuple[float, ...]
    accelerations: tuple[float, ...]
    junction: float

    def along(self, unit: Sequence[float], limits: Sequence[float]) -> float:
        """Return what a direction may have of a limit, so that no axis exceeds its own."""
        shares = zip(limits, unit, strict=True)
        return min((limit / abs(share) for limit, share in shares if share), default=math.inf)

    def rates_hz(self) -> tuple[float, ...]:
        """Return the fastest steps a second of each motor."""
        return tuple(map(math.prod, zip(self.rates, self.steps_per_unit, strict=True)))


@dataclass(frozen=True, slots=True)
class MotorPath:
    """One line: its length, its direction, and the speed and acceleration it is driven with.

    `rate_hz` is that speed in steps a second of the busiest motor.
    """

    length: float
    unit: tuple[float, ...]
    speed: float
    acceleration: float
    rate_hz: float = math.inf

    @property
    def nominal_s(self) -> float:
        """How long it takes without ramps."""
        return self.length / self.speed

    def rest(self, share: float) -> MotorPath:
        """Return what is left of it when a share has been driven."""
        return replace(self, length=self.length * max(1.0 - share, STRAIGHT))


def way(steps: Motors, duration_s: float, limits: Limits) -> MotorPath:
    """Return the line of some steps that shall last so long, or longer where the axes are slow."""
    parts = [count / per for count, per in zip(steps, limits.steps_per_unit, strict=True)]
    length = math.hypot(*parts)
    unit = tuple(part / length for part in parts)
    speed = min(length / max(duration_s, 1e-9), limits.along(unit, limits.rates))
    rate_hz = speed / length * steps.largest
    return MotorPath(length, unit, speed, limits.along(unit, limits.accelerations), rate_hz)


def corner_speed(one: MotorPath, other: MotorPath, limits: Limits) -> float:
    """Return how fast the corner between two lines may be passed."""
    fastest = min(one.speed, other.speed)
    cosine = -sum(a * b for a, b in zip(one.unit, other.unit, strict=True))
    if cosine > 1.0 - STRAIGHT:
        return 0.0
    if cosine < STRAIGHT - 1.0:
        return fastest
    turn = [b - a for a, b in zip(one.unit, other.unit, strict=True)]
    size = math.hypot(*turn)
    slope = limits.along([part / size for part in turn], limits.accelerations)
    half_sine = math.sqrt(0.5 * (1.0 - cosine))
    return min(fastest, math.sqrt(slope * limits.junction * half_sine / (1.0 - half_sine)))


def planned_s(ways: Sequence[MotorPath], limits: Limits) -> float:
    """Return how long lines take from a stand-still to a stand-still."""
    speeds = [0.0, *(corner_speed(a, b, limits) for a, b in pairwise(ways)), 0.0]
    for index in range(len(ways) - 1, -1, -1):
        room = 2.0 * ways[index].acceleration * ways[index].length
        speeds[index] = min(speeds[index], math.sqrt(speeds[index + 1] ** 2 + room))
    total_s = 0.0
    for index, one in enumerate(ways):
        room = 2.0 * one.acceleration * one.length
        speeds[index + 1] = min(speeds[index + 1], math.sqrt(speeds[index] ** 2 + room))
        total_s += trapezoid_s(one, speeds[index], speeds[index + 1])
    return total_s


def trapezoid_s(one: MotorPath, enter: float, leave: float) -> float:
    """Return how long a line takes that is entered and left at these speeds."""
    slope = one.acceleration
    peak = min(one.speed, math.sqrt(slope * one.length + (enter**2 + leave**2) / 2.0))
    peak = max(peak, enter, leave)
    ramps = (2.0 * peak**2 - enter**2 - leave**2) / (2.0 * slope)
    return (2.0 * peak - enter - leave) / slope + max(one.length - ramps, 0.0) / peak


# The segment buffer of a GRBL board: motion that it has computed and no longer changes.
#
# The stepper driver of the firmware computes segments of 10 ms ahead of the motors. A segment
# holds at least 1.25 steps of the busiest motor, so that a slow one lasts longer. Nothing that
# arrives later changes these segments: a feed hold begins to brake after them, the planner reads
# empty while they are still to be driven, and a queue that ends within them starves.
#
# Sources: gnea/grbl grbl/stepper.c (st_prep_buffer), stepper.h; grblHAL/core stepper.h; FluidNC
# `stepping/segments`. Seen: the Mega goes on for 0.43 s at 31 steps/s, a 328p for 0.24 s.

SEGMENT_S = 0.01
STEPS_A_SEGMENT = 1.25
SLOWEST_HZ = 16e6 / (8 * 65535)
"""An 8-bit board turns a motor no slower: its step timer counts 16 bits at 16 MHz, over at most
eight interrupts a step. 40 steps at 5, 10, 20 and 30 steps/s took 1.278 s each. The driver asks
for no slower rate of any board, as segments would last longer then."""
LAST_STEP_S = 1.0 / SLOWEST_HZ
"""The step that a motor has begun is made, however slowly it comes."""
SHORTEST_HZ = STEPS_A_SEGMENT / SEGMENT_S
"""At this rate and above it, a segment lasts no longer than 10 ms."""
FEW_BLOCKS = 15
"""The planner of an ATmega328P. Boards with a larger one have more segments, too."""
SEGMENTS: Mapping[Variant, int] = MappingProxyType(
    {Variant.GRBL: 9, Variant.GRBLHAL: 10, Variant.FLUIDNC: 12}
)
"""How many segments a firmware computes ahead: the ring of an ATmega2560 has ten places, one of
which stays free. Those of grblHAL and FluidNC are their sources' defaults."""
SEGMENTS_328P = 5


def segments_of(variant: Variant, blocks: int | None) -> int:
    """Return how many segments a board computes ahead, by its firmware and its planner's size."""
    small = variant is Variant.GRBL and blocks is not None and blocks <= FEW_BLOCKS
    return SEGMENTS_328P if small else SEGMENTS[variant]


@dataclass(frozen=True, slots=True)
class SegmentBuffer:
    """The buffer of one board, which computes `segments` ahead."""

    segments: int

    @property
    def longest_s(self) -> float:
        """How much motion it holds at most: at the slowest rate."""
        return self.segments * self._segment_s(SLOWEST_HZ)

    def longest_of_s(self, parts: Sequence[StopPart], piece_s: float) -> float:
        """Return how much of a motion it holds at most, wherever in it.

        The motion is sent in pieces of `piece_s` or longer, or part by part where those are
        shorter; in whole steps, so that a piece may be one step short of its rate. As the window
        slides along, what it holds changes evenly until one of its ends comes to where two parts
        meet: the longest begins or ends there.
        """
        counted = [
            (
                part.duration_s,
                self._segment_s(part.rate_hz - 1.0 / max(min(part.duration_s, piece_s), 1e-6)),
            )
            for part in parts
        ]
        ways = (counted, counted[::-1])
        return max(self._filled_s(way, start) for way in ways for start in range(len(way)))

    @staticmethod
    def slow_ramp_s(rate_hz: float, slope: float) -> float:
        """Return by how much the board's own ramp to a rate makes segments longer, at most.

        Below `SHORTEST_HZ` they are longer than 10 ms, and a ramp is below it for so long.
        """
        return min(rate_hz, SHORTEST_HZ) / slope

    def _filled_s(self, counted: Sequence[tuple[float, float]], start: int) -> float:
        """Return how long the segments of as many parts last as it has room for, from one on."""
        left, total_s = float(self.segments), 0.0
        for index in range(start, len(counted)):
            duration_s, segment_s = counted[index]
            count = min(duration_s / segment_s, left)
            left, total_s = left - count, total_s + count * segment_s
            if left <= 0.0:
                break
        return total_s

    def most_steps(self, fastest_hz: float) -> float:
        """Return how many steps of a motor it holds at most, which turns no faster than this.

        A segment lasts 10 ms, or as many times 10 ms as it takes for 1.25 steps: less than 2.5.
        """
        return self.segments * max(fastest_hz * SEGMENT_S, 2.0 * STEPS_A_SEGMENT)

    def holds_s(self, ways: Iterable[MotorPath]) -> float:
        """Return how much of the motion along lines it holds, from where the first one begins."""
        left, total_s, segment_s = float(self.segments), 0.0, 0.0
        for each in ways:
            segment_s = self._segment_s(each.rate_hz)
            count = each.nominal_s / segment_s
            if count >= left:
                break
            left -= count
            total_s += each.nominal_s
        return total_s + left * segment_s

    @staticmethod
    def _segment_s(rate_hz: float) -> float:
        least_s = STEPS_A_SEGMENT / max(rate_hz, SLOWEST_HZ)
        return SEGMENT_S * math.ceil(least_s / SEGMENT_S - 1e-9)


# How fast this arm's motors turn on the board, and how long a motion goes on after a stop.

LATENCY_S = 0.03
"""What a host may be late by."""
LONGEST_LINE = 81
AGAIN_S = 0.04
"""A stop that is lost on the wire, or the report that would show it, is followed by another."""
CONFIRMED_S = 0.12
"""Looks at a board that brakes, its reset and its banner."""
KILLED_S = 0.3
"""A board that is reset in motion keeps its motors for $1, 255 ms, and lets go of them then."""


@dataclass(frozen=True, slots=True)
class MotionBounds:
    """What the board's axes can do for this arm, whose motors turn at most `most_hz`.

    `limits` are the arm file's until the board's own settings are read. A byte takes `byte_s` on
    the wire.
    """

    limits: Limits
    most_hz: tuple[float, ...]
    segments: SegmentBuffer
    byte_s: float

    @property
    def _fastest(self) -> list[tuple[float, float]]:
        """Each motor's fastest rate on this arm, and its acceleration: steps/s and steps/s^2."""
        limits = self.limits
        each = zip(limits.rates_hz(), self.most_hz, strict=True)
        slopes = zip(limits.accelerations, limits.steps_per_unit, strict=True)
        return [(min(pair), slope * per) for pair, (slope, per) in zip(each, slopes, strict=True)]

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate itself, within what the board can do without pauses between steps."""
        return max(min(rate_hz, max(self.limits.rates_hz())), SLOWEST_HZ)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the slowest axis takes for so many steps, from rest to rest."""
        slopes = zip(self.limits.accelerations, self.limits.steps_per_unit, strict=True)
        slowest = min(*self.limits.rates_hz(), rate_hz)
        least = min(slope * per for slope, per in slopes)
        return trapezoid_s(MotorPath(max(steps, 1e-6), (1.0,), slowest, least), 0.0, 0.0)

    def ramp_s(self, parts: Sequence[StopPart] = ()) -> float:
        """Return how long a motion brakes at most; of no parts, one at any speed.

        No motor turns faster than the busiest does, or than this arm drives it.
        """
        rate_hz = max((part.rate_hz for part in parts), default=math.inf)
        return max(min(rate_hz, fastest_hz) / slope for fastest_hz, slope in self._fastest)

    @property
    def slowest_stop_s(self) -> float:
        """How long a board takes at most from a hold that it has heard to the last step.

        It drives what its segment buffer holds, brakes, and makes the step that it has begun.
        """
        return self.segments.longest_s + self.ramp_s() + LAST_STEP_S

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound what the board still drives; without a host, what was sent ahead as well.

        The bound allows for one lost byte, which is sent again after `AGAIN_S`. What was sent ahead
        is driven to its end, where its last line brakes: half of that ramp is more than its time.
        """
        wire_s = LATENCY_S + LONGEST_LINE * self.byte_s
        heard_s = wire_s + AGAIN_S
        piece_s = segment_s(burst_s) / 2.0  # a part is cut into equal ones
        brakes_s, held_s = self.ramp_s(parts), self._held_longest_s(parts, piece_s)
        held_way_s = self._held_full_speed_s(parts)
        stands_s = heard_s + held_s + brakes_s + LAST_STEP_S
        return Stopping(
            max(stands_s, heard_s + KILLED_S),
            heard_s + held_way_s + brakes_s / 2.0,
            burst_s + wire_s + held_s + brakes_s + LAST_STEP_S,
            burst_s + wire_s + held_way_s,
            max(stands_s + CONFIRMED_S, heard_s + KILLED_S),
        )

    def _held_longest_s(self, parts: Sequence[StopPart], piece_s: float) -> float:
        """Return for how long the board drives what its segment buffer holds, at most.

        Where the motion speeds up or slows down, its segments are those of slower rates.
        """
        if not parts:
            return self.segments.longest_s
        held_s = self.segments.longest_of_s(parts, piece_s)
        slopes = [slope for _, slope in self._fastest]
        ramps_s = self.segments.slow_ramp_s(max(p.rate_hz for p in parts), min(slopes))
        return min(held_s + ramps_s, self.segments.longest_s)

    def _held_full_speed_s(self, parts: Sequence[StopPart]) -> float:
        """Return how long the motion takes at its speed for the steps that the buffer can hold.

        Of no parts, a single motor at its full speed: the slowest takes longest.
        """
        rates_hz = [part.rate_hz for part in parts] or [each for each, _ in self._fastest]
        return max((self.segments.most_steps(rate) + 1.0) / rate for rate in rates_hz)


# The lines of one motion that have been sent: which are done, where the arm is.
#
# Nothing but a report says that a line was driven. A block leaves the board's planner as soon as
# its last segment is computed, so that the reported position has the last word: a line is behind us
# when the position lies on a later one, or when the board is Idle with an empty planner.

REPORT_S = 0.15
"""A report may be this old. A position that is farther behind the planner than the segment buffer
and such a report explain belongs to a way that went wrong: back along itself, say."""


@dataclass(frozen=True, slots=True)
class InFlightLine:
    """One line: from where to where, absolute, and how it is driven."""

    start: Motors
    end: Motors
    way: MotorPath
    sent_s: float

    def share_at(self, position: Motors, tolerance: float) -> float | None:
        """Return how much of it has been driven at a position on it; None for one off it."""
        delta = self.end - self.start
        made = position - self.start
        busiest = max(range(len(delta)), key=lambda motor: abs(delta[motor]))
        share = min(max(made[busiest] / delta[busiest], 0.0), 1.0)
        off = max(abs(count - whole * share) for count, whole in zip(made, delta, strict=True))
        return share if off <= tolerance else None


class InFlightLines:
    """The lines under way. `unanswered` counts the last of them, which have had no ok.

    `ends_s` is when the motors should come to a stand.
    """

    def __init__(
        self, start: Motors, limits: Limits, tolerance: float, segments: SegmentBuffer
    ) -> None:
        self.start = self.end = start
        self.unanswered = 0
        self.oks = 0
        self._limits = limits
        self._tolerance = tolerance
        self._segments = segments
        self.ends_s = -math.inf
        self._lines: deque[InFlightLine] = deque()
        self._share = 0.0

    @property
    def empty(self) -> bool:
        """Tell whether every line that was sent is known to be done."""
        return not self._lines

    @property
    def waiting(self) -> int:
        """How many lines are not known to be done."""
        return len(self._lines)

    @property
    def oldest_sent_s(self) -> float:
        """When the oldest line without an ok was sent."""
        return self._lines[-self.unanswered].sent_s

    def send(self, steps: Motors, way: MotorPath, now_s: float) -> None:
        """Take in a line that is sent now."""
        lasts_s = way.nominal_s if self._lines else planned_s([way], self._limits)
        self.ends_s = max(self.ends_s, now_s) + lasts_s
        self._lines.append(InFlightLine(self.end, self.end + steps, way, now_s))
        self.end = self.end + steps
        self.unanswered += 1

    def answered(self, now_s: float) -> None:
        """Take in an ok: the oldest line without one is planned, and begins if it is alone."""
        if len(self._lines) == 1:
            self.ends_s = max(self.ends_s, now_s + planned_s(self.rest(), self._limits))
        self.unanswered = max(self.unanswered - 1, 0)
        self.oks += 1

    def take_as_answered(self) -> None:
        """Give up waiting for oks that were lost."""
        self.unanswered = 0

    def rest(self, more: MotorPath | None = None) -> list[MotorPath]:
        """Return what is left to drive, and one way more."""
        ways = [line.way for line in self._lines]
        if ways:
            ways[0] = ways[0].rest(self._share)
        return ways if more is None else [*ways, more]

    def fits(self, more: MotorPath, ahead_s: float, ramp_s: float) -> bool:
        """Tell whether one way more leaves the planner no more than so much time to drive.

        What the segment buffer holds comes on top, since the planner does not have it any more,
        and so do ramps: lines are driven from wherever they are to a stand-still.
        """
        ways = self.rest(more)
        if len(ways) == 1:
            return True
        ahead_s += self._segments.holds_s(ways)
        nominal_s = sum(each.nominal_s for each in ways)
        return (
            nominal_s <= ahead_s + 1e-6 and planned_s(ways, self._limits) <= ahead_s + ramp_s + 1e-6
        )

    def has_room(self, guess_s: float, ahead_s: float) -> bool:
        """Tell whether a line of such a duration would fit behind those under way."""
        ways = self.rest()
        if not ways:
            return True
        ahead_s += self._segments.holds_s(ways)
        return sum(each.nominal_s for each in ways) + guess_s <= ahead_s + 1e-6

    def ends_by(self, time_s: float) -> bool:
        """Tell whether the motion that is known to be under way may have ended by a time."""
        return bool(self._lines) and self.ends_s <= time_s

    def expected_s(self) -> float:
        """Return how long the rest should take."""
        return planned_s(self.rest(), self._limits)

    def at_end(self, position: Motors) -> bool:
        """Tell whether a position is where the last line leads."""
        return position == self.end

    def report(
        self, position: Motors, now_s: float, *, idle: bool, planned: int | None = None
    ) -> bool:
        """Take in a report; False where its position is off every line that can be under way.

        `idle` says that the board stands and that its planner is empty: what it has acknowledged
        is done. `planned` is how many lines its planner holds.
        """
        if idle:
            self._drop(len(self._lines) - self.unanswered)
        if not self._lines:
            return (position - self.start).largest <= self._tolerance
        for index, line in enumerate(self._lines):
            share = line.share_at(position, self._tolerance)
            if share is not None:
                late = self._too_late(position, index, share, planned)
                self._drop(index)
                self._share = share
                self.ends_s = now_s + sum(each.nominal_s for each in self.rest())
                return not late
        return False

    def _too_late(self, position: Motors, index: int, share: float, planned: int | None) -> bool:
        """Tell whether a position lies farther behind the planner than its segments explain."""
        computed = 0 if planned is None else len(self._lines) - self.unanswered - planned
        lines = list(self._lines)[index : max(computed, 0)]
        if not lines or (lines[-1].end - position).largest <= self._tolerance:
            return False
        ways = [lines[0].way.rest(share), *(line.way for line in lines[1:])]
        late_s = sum(each.nominal_s for each in ways)
        return late_s > self._segments.holds_s(ways) + REPORT_S

    def _drop(self, count: int) -> None:
        for _ in range(count):
            self.start = self._lines.popleft().end
            self._share = 0.0
        self.unanswered = min(self.unanswered, len(self._lines))  # an ok was lost on the way


@dataclass(slots=True)
class LineTrip:
    """One motion under way: where its lines come from, and what is known of those sent.

    A motion that is slower than the board can is `lead_s` ahead of its time, and no line is sent
    before `not_before_s`. `waits` is true in a pause. The motors began to turn at `began_s`.
    The last report shows what was so at `seen_s`, when it was asked for.
    """

    segments: Iterator[MoveBy]
    lines: InFlightLines
    bounds: MotionBounds
    ahead_s: float
    jog: bool
    drawn: MoveBy | None = None
    exhausted: bool = False
    not_before_s: float = -math.inf
    waits: bool = False
    lead_s: float = 0.0
    began_s: float = -math.inf
    polled_s: float = -math.inf
    awaiting: bool = False
    seen_s: float = -math.inf
    changed_s: float = 0.0
    off: int = 0
    steps: int = 0
    dry: bool = False
    starved: bool = False
    guess_s: float = 0.0

    @property
    def finished(self) -> bool:
        """Tell whether there is nothing more to send, and all that was sent is done."""
        return self.exhausted and self.drawn is None and self.lines.empty

    @property
    def waits_for_ok(self) -> bool:
        """Whether a line has to be answered before the next: in a jog, and the first of all.

        A stray character spoils the first one: it is refused, and nothing has moved.
        """
        return self.lines.unanswered > 0 and (self.jog or not self.lines.oks)
