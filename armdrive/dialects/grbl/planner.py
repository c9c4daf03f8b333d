"""A model of how a GRBL board drives lines: planner times, segment buffer, and stops.

The driver has to know how long the lines take that it has sent, although the board does not say so:
to send no more than the announced time ahead, to notice a motion that has gone wrong, and to
announce how far the arm continues after a stop. The parts, from the board's inside out:

    planned_s        how long lines take in the planner: ramps, and corners passed in motion
    SegmentBuffer    what has left the planner, and no command can change any more
    MotionBounds     the two together: how long and how far a motion continues
    InFlightLines    the lines of one motion: which are done, and how much is left to drive
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from armdrive.abilities import segment_s
from armdrive.dialects.controller import HOST_DELAY_S, StopPart, Stopping
from armdrive.dialects.grbl.variants import SLOWEST_HZ
from kinematics.spaces import Motors

# The time that a board's planner takes for queued lines: trapezoids, with corners passed in motion.
#
# Lengths are in the board's own units ("mm"). Source of the corner speed and of the two passes:
# gnea/grbl grbl/planner.c (plan_buffer_line, planner_recalculate).

# A cosine this close to -1 means no turn at all.
COSINE_TOLERANCE = 1e-6
# The share of a line that is always left to drive, so that its length stays positive.
SMALLEST_REST = 1e-6


@dataclass(frozen=True, slots=True)
class Limits:
    """The axes' limits: steps per unit, units per second, units per second squared.

    `junction` is the junction deviation ($11) in units. It determines the speed in corners.
    """

    steps_per_unit: tuple[float, ...]
    rates: tuple[float, ...]
    accelerations: tuple[float, ...]
    junction: float

    def along(self, unit: Sequence[float], limits: Sequence[float]) -> float:
        """Return the limit along a direction that keeps every axis within its own limit."""
        shares = zip(limits, unit, strict=True)
        return min((limit / abs(share) for limit, share in shares if share), default=math.inf)

    def rates_hz(self) -> tuple[float, ...]:
        """Return each motor's highest rate in steps a second."""
        return tuple(map(math.prod, zip(self.rates, self.steps_per_unit, strict=True)))


@dataclass(frozen=True, slots=True)
class MotorPath:
    """One line: its length, its direction, its speed and its acceleration.

    `rate_hz` is the speed in steps a second of the busiest motor.
    """

    length: float
    unit: tuple[float, ...]
    speed: float
    acceleration: float
    rate_hz: float = math.inf

    @property
    def nominal_s(self) -> float:
        """Duration without ramps."""
        return self.length / self.speed

    def rest(self, share: float) -> MotorPath:
        """Return the rest of the line after a share of it has been driven."""
        return replace(self, length=self.length * max(1.0 - share, SMALLEST_REST))


def line_path(steps: Motors, duration_s: float, limits: Limits) -> MotorPath:
    """Return the line for these steps, which takes `duration_s` or longer if an axis is slow."""
    parts = [count / per for count, per in zip(steps, limits.steps_per_unit, strict=True)]
    length = math.hypot(*parts)
    unit = tuple(part / length for part in parts)
    speed = min(length / max(duration_s, 1e-9), limits.along(unit, limits.rates))
    rate_hz = speed / length * steps.largest
    return MotorPath(length, unit, speed, limits.along(unit, limits.accelerations), rate_hz)


def corner_speed(one: MotorPath, other: MotorPath, limits: Limits) -> float:
    """Return the highest speed in the corner between two lines."""
    fastest = min(one.speed, other.speed)
    # of the angle between the lines as sides of the corner, as the firmware computes it
    cosine = -sum(a * b for a, b in zip(one.unit, other.unit, strict=True))
    if cosine < COSINE_TOLERANCE - 1.0:
        return fastest
    turn = [b - a for a, b in zip(one.unit, other.unit, strict=True)]
    size = math.hypot(*turn)
    slope = limits.along([part / size for part in turn], limits.accelerations)
    half_sine = math.sqrt(max(0.5 * (1.0 - cosine), 0.0))
    return min(fastest, math.sqrt(slope * limits.junction * half_sine / (1.0 - half_sine)))


def planned_s(paths: Sequence[MotorPath], limits: Limits) -> float:
    """Return how long consecutive lines take from rest to rest."""
    speeds = [0.0, *(corner_speed(a, b, limits) for a, b in pairwise(paths)), 0.0]
    # backwards: a line is entered no faster than it can brake for its end
    for index in range(len(paths) - 1, -1, -1):
        room = 2.0 * paths[index].acceleration * paths[index].length
        speeds[index] = min(speeds[index], math.sqrt(speeds[index + 1] ** 2 + room))
    total_s = 0.0
    # forwards: a line is left no faster than it can accelerate to
    for index, one in enumerate(paths):
        room = 2.0 * one.acceleration * one.length
        speeds[index + 1] = min(speeds[index + 1], math.sqrt(speeds[index] ** 2 + room))
        total_s += trapezoid_s(one, speeds[index], speeds[index + 1])
    return total_s


def trapezoid_s(one: MotorPath, enter: float, leave: float) -> float:
    """Return how long a line takes if it is entered and left at these speeds."""
    slope = one.acceleration
    # where both ramps would meet, if the line were not limited in speed
    peak = min(one.speed, math.sqrt(slope * one.length + (enter**2 + leave**2) / 2.0))
    peak = max(peak, enter, leave)
    ramps = (2.0 * peak**2 - enter**2 - leave**2) / (2.0 * slope)
    return (2.0 * peak - enter - leave) / slope + max(one.length - ramps, 0.0) / peak


# The segment buffer of a GRBL board: motion that is already computed and no longer changes.
#
# The firmware's stepper driver computes segments of 10 ms ahead of the motors. A segment holds at
# least 1.25 steps of the busiest motor, so segments of slow motion last longer. No later command
# changes these segments: a feed hold brakes only after them, the planner reports empty while they
# are still being driven, and a queue that ends within them runs dry.
#
# Sources: gnea/grbl grbl/stepper.c (st_prep_buffer), stepper.h; grblHAL/core stepper.h; FluidNC
# `stepping/segments`. Measured at 31 steps/s: the Mega continues for 0.43 s, grblHAL for 0.46 s, a
# 328p for 0.24 s.

SEGMENT_S = 0.01
# The firmware's `REQ_MM_INCREMENT_SCALAR`.
STEPS_A_SEGMENT = 1.25
# A step that has begun is always completed; this is the slowest one.
LAST_STEP_S = 1.0 / SLOWEST_HZ
# From this rate up, a segment lasts only 10 ms.
SHORTEST_HZ = STEPS_A_SEGMENT / SEGMENT_S


def segment_lasts_s(rate_hz: float) -> float:
    """Return how long a segment lasts at this rate of the busiest motor."""
    least_s = STEPS_A_SEGMENT / max(rate_hz, SLOWEST_HZ)
    return SEGMENT_S * math.ceil(least_s / SEGMENT_S - 1e-9)


@dataclass(frozen=True, slots=True)
class SegmentBuffer:
    """The segment buffer of one board, which computes `segments` ahead.

    Its motors turn no slower than `slowest_hz`.
    """

    segments: int
    slowest_hz: float = SLOWEST_HZ

    @property
    def longest_s(self) -> float:
        """The longest motion that the buffer can hold: at the slowest rate of any board.

        FluidNC is never so slow. The rest covers that it obeys a stop late while homing waits at a
        switch: it still begins the next motion.
        """
        return self.segments * segment_lasts_s(SLOWEST_HZ)

    def most_steps(self, fastest_hz: float) -> float:
        """Bound the steps that the buffer holds for a motor that turns no faster than this.

        A segment lasts 10 ms, or the multiple of 10 ms that 1.25 steps need. Then it holds less
        than 2.5 steps.
        """
        return self.segments * max(fastest_hz * SEGMENT_S, 2.0 * STEPS_A_SEGMENT)

    def holds_s(self, pieces: Iterable[tuple[float, float]]) -> float:
        """Return how much of a motion the buffer holds, from its start.

        The motion is given by durations and rates, one after the other.
        """
        left, total_s = float(self.segments), 0.0
        for duration_s, rate_hz in pieces:
            lasts_s = segment_lasts_s(rate_hz)
            count = min(duration_s / lasts_s, left)
            left, total_s = left - count, total_s + count * lasts_s
        return total_s


# The speed of this arm's motors on the board, and how long a motion continues after a stop.

# Bytes on the wire before a stop arrives: a line of 79 characters, its end, and the stop byte.
LONGEST_LINE = 81
# If a stop, or the report that would show its effect, is lost, the stop is repeated after this.
RESEND_S = 0.04
# A board reset in motion holds its motors for the time in $1, 255 ms, and then releases them.
KILLED_S = 0.3


@dataclass(frozen=True, slots=True)
class MotionBounds:
    """The bounds of this arm's motion on the board; its motors turn at most at `most_hz`.

    `limits` are the arm file's until the board's settings have been read. A byte takes `byte_s` on
    the wire.
    """

    limits: Limits
    most_hz: tuple[float, ...]
    segments: SegmentBuffer
    byte_s: float

    @property
    def _fastest(self) -> list[tuple[float, float]]:
        """Each motor's highest rate on this arm in steps/s, and its acceleration in steps/s^2."""
        limits = self.limits
        each = zip(limits.rates_hz(), self.most_hz, strict=True)
        slopes = zip(limits.accelerations, limits.steps_per_unit, strict=True)
        return [(min(pair), slope * per) for pair, (slope, per) in zip(each, slopes, strict=True)]

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate, limited to what the board can do without pausing between steps."""
        return max(min(rate_hz, max(self.limits.rates_hz())), self.segments.slowest_hz)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return the time the slowest axis takes for these steps, from rest to rest."""
        slowest = min(*self.limits.rates_hz(), rate_hz)
        least = min(slope for _, slope in self._fastest)
        return trapezoid_s(MotorPath(max(steps, 1e-6), (1.0,), slowest, least), 0.0, 0.0)

    def ramp_s(self, parts: Sequence[StopPart] = ()) -> float:
        """Bound how long a motion takes to brake; without parts, from any speed.

        No motor turns faster than the busiest one, or faster than this arm drives it.
        """
        rate_hz = max((part.rate_hz for part in parts), default=math.inf)
        return max(min(rate_hz, fastest_hz) / slope for fastest_hz, slope in self._fastest)

    @property
    def slowest_stop_s(self) -> float:
        """Bound of the time from the arrival of a feed hold to the last step.

        The board drives the contents of its segment buffer, brakes, and completes the last step.
        """
        return self.segments.longest_s + self.ramp_s() + LAST_STEP_S

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound the motion after a stop and, if the host falls silent, the motion sent ahead too.

        The bound allows for one lost stop byte, which is sent again after `RESEND_S`. Motion sent
        ahead is driven to its end, where its last line brakes; half of that ramp comes on top of
        the line's duration at full speed.
        """
        wire_s = HOST_DELAY_S + LONGEST_LINE * self.byte_s
        heard_s = wire_s + RESEND_S
        brakes_s, held_s = self.ramp_s(parts), self._held_s(parts, segment_s(burst_s))
        # how long the steps in the buffer take at the motion's own speed, which the distance needs;
        # without parts, of a single motor at full speed: the slowest one takes longest
        rates_hz = [part.rate_hz for part in parts] or [each for each, _ in self._fastest]
        held_way_s = max((self.segments.most_steps(rate) + 1.0) / rate for rate in rates_hz)
        stands_s = heard_s + held_s + brakes_s + LAST_STEP_S
        return Stopping(
            max(stands_s, heard_s + KILLED_S),
            heard_s + held_way_s + brakes_s / 2.0,
            burst_s + wire_s + held_s + brakes_s + LAST_STEP_S,
            burst_s + wire_s + held_way_s,
        )

    def _held_s(self, parts: Sequence[StopPart], piece_s: float) -> float:
        """Bound how long the board takes to drive the contents of its segment buffer.

        As the buffer's window slides along the motion, its duration changes linearly until one of
        its ends reaches a boundary between two parts. So the longest window begins or ends at a
        boundary. A part is sent in equal pieces of at least half of `piece_s`. They consist of
        whole steps, so a piece's rate may be one step below the planned one. Segments of a ramp
        last as long as those of a slower rate: longer than 10 ms only below `SHORTEST_HZ`.
        """
        longest_s = self.segments.longest_s
        if not parts:
            return longest_s
        pieces = [
            (part.duration_s, part.rate_hz - 1.0 / max(min(part.duration_s, piece_s / 2.0), 1e-6))
            for part in parts
        ]
        fastest_hz = max(part.rate_hz for part in parts)
        ramps_s = min(fastest_hz, SHORTEST_HZ) / min(slope for _, slope in self._fastest)
        held_s = max(
            self.segments.holds_s(ordered[start:])
            for ordered in (pieces, pieces[::-1])
            for start in range(len(pieces))
        )
        return min(held_s + ramps_s, longest_s)


# The lines sent for one motion: which of them are done, and how much is left to drive.
#
# Only a report shows that a line has been driven. A line leaves the board's planner as soon as its
# last segment is computed, so the reported position decides: a line is done when the position lies
# on a later line, or when the board is Idle with an empty planner.


@dataclass(frozen=True, slots=True)
class InFlightLine:
    """One line that has been sent: its absolute start and end, and how it is driven."""

    start: Motors
    end: Motors
    path: MotorPath

    def share_at(self, position: Motors, tolerance: float, least: float) -> float | None:
        """Return the share driven when the arm is at a position.

        None if it is off the line, or farther back than a share of `least`.
        """
        delta = self.end - self.start
        made = position - self.start
        busiest = max(range(len(delta)), key=lambda motor: abs(delta[motor]))
        share = min(max(made[busiest] / delta[busiest], 0.0), 1.0)
        off = max(abs(count - whole * share) for count, whole in zip(made, delta, strict=True))
        back = (least - share) * abs(delta[busiest])
        return max(share, least) if max(off, back) <= tolerance else None


class InFlightLines:
    """The lines that are not yet known to be done; the last one may be `unanswered`.

    A motor may be off its line by `tolerance` steps. `ends_s` is when the motors should stop, and
    `sent_s` when the last line was sent.
    """

    def __init__(
        self, start: Motors, limits: Limits, tolerance: float, segments: SegmentBuffer
    ) -> None:
        self.start = self.end = start
        self.unanswered = False
        self.oks = 0
        self.ends_s = self.sent_s = -math.inf
        self._limits = limits
        self._tolerance = tolerance
        self._segments = segments
        self._lines: deque[InFlightLine] = deque()
        self._share = 0.0

    @property
    def empty(self) -> bool:
        """Whether every line that was sent is known to be done."""
        return not self._lines

    @property
    def progress(self) -> tuple[int, Motors, float]:
        """Changes whenever more of the lines is known to be done."""
        return len(self._lines), self.start, self._share

    def send(self, steps: Motors, path: MotorPath, now_s: float) -> None:
        """Record a line that is sent now."""
        lasts_s = path.nominal_s if self._lines else planned_s([path], self._limits)
        self.ends_s = max(self.ends_s, now_s) + lasts_s
        self._lines.append(InFlightLine(self.end, self.end + steps, path))
        self.end = self.end + steps
        self.unanswered, self.sent_s = True, now_s

    def answered(self, now_s: float) -> None:
        """Record an ok: the last line is planned, and starts if it is alone."""
        if len(self._lines) == 1:
            self.ends_s = max(self.ends_s, now_s + self.expected_s())
        self.unanswered = False
        self.oks += 1

    def ahead_s(self, ramp_s: float, *more: MotorPath) -> float:
        """Return for how long the planner's lines move the arm, with `more` behind them.

        What the segment buffer holds does not count, since it has left the planner, and neither do
        the ramps: the lines are driven from the present position to a stop.
        """
        paths = [*self._rest(), *more]
        nominal_s = math.fsum(each.nominal_s for each in paths)
        lasts_s = max(nominal_s, planned_s(paths, self._limits) - ramp_s)
        return lasts_s - self._segments.holds_s((each.nominal_s, each.rate_hz) for each in paths)

    def expected_s(self) -> float:
        """Return the expected duration of the lines left to drive."""
        return planned_s(self._rest(), self._limits)

    def _rest(self) -> list[MotorPath]:
        paths = [line.path for line in self._lines]
        return [paths[0].rest(self._share), *paths[1:]] if paths else []

    def report(self, position: Motors, now_s: float, *, idle: bool) -> bool:
        """Record a report; return False if no line that can be under way explains its position.

        `idle` means that the board stands with an empty planner, so every acknowledged line is
        done.
        """
        if idle:
            self._drop(len(self._lines) - self.unanswered)
        if not self._lines:
            return (position - self.start).largest <= self._tolerance
        # the earliest line that explains the position is the one under way; all before it are done
        for index, line in enumerate(self._lines):
            share = line.share_at(position, self._tolerance, 0.0 if index else self._share)
            if share is not None:
                self._drop(index)
                self._share = share
                self.ends_s = now_s + math.fsum(each.nominal_s for each in self._rest())
                return True
        return False

    def _drop(self, count: int) -> None:
        for _ in range(count):
            self.start = self._lines.popleft().end
            self._share = 0.0
        self.unanswered = self.unanswered and bool(self._lines)  # an ok was lost on the wire
