"""When a path is where: the quickest way along chords under every coordinate's and motor's limits.

Coordinates are joints in rad and, where the gripper moves, its opening in mm; times in s. A path
is passed from rest to rest without stopping. Its shape is never touched: near a singularity,
where a joint turns fast, the path slows.

Two corners are one straight motion, all coordinates in proportion, timed exactly: a trapezoid, or
seven phases. More corners stand for a smooth curve (a straight line of the tip, an arc, a blend)
cut into chords (where a corner is meant to be sharp, stop there, or blend it); what holds is this,
and is tested:

- No coordinate and no motor is ever faster than its limit.
- No acceleration is passed where the curve's direction turns evenly from the middle of each chord
  to that of the next. The chords' own speeds jump at a corner, by what this turn makes up between
  two middles: the finer the chords, the less.
- With a build-up time the same holds. What speeds up and brakes along the path then changes by
  the limit in half that time at the quickest, where speeding up turns into braking; on a straight
  motion, in that time.

Without any acceleration limit, each chord takes its least time at full speed, and the build-up
time has nothing to build up.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from typing import NamedTuple

from kinematics.errors import KinematicsError, finite
from kinematics.profiles import Profile, jerk_limited
from kinematics.timing_cells import Chord, cells_of, widened
from kinematics.timing_limits import MotionLimits, Point
from kinematics.timing_passes import quickest
from kinematics.timing_smooth import averaged

INSTANT_S = 1e-9
"""A chord that takes less at full speed takes no time: its corners are one, but for rounding."""

SHORTEST = 0.01
"""Share of a longest piece below which none is cut off one of constant speed."""

ROUNDING = 1e-9
"""Share of a longest piece by which one may be longer than that."""


class Piece(NamedTuple):
    """A straight part of a motion at constant speed: where it ends, and how long it takes."""

    point: Point
    duration_s: float


@dataclass(frozen=True, slots=True)
class TimedPath:
    """Corners joined by straight chords, and the time at which each is passed.

    `marks` are the corners' places on the path's parameter, which `profile` runs through.
    """

    corners: tuple[Point, ...]
    marks: tuple[float, ...] = field(repr=False)
    profile: Profile = field(repr=False)
    times_s: tuple[float, ...] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "times_s", tuple(map(self.profile.when, self.marks)))

    @property
    def duration_s(self) -> float:
        """How long the whole path takes."""
        return self.profile.duration_s

    def at(self, t_s: float) -> Point:
        """Return the point at a time; the corners at both ends, and beyond them, exactly."""
        place = self.profile.at(t_s)[0]
        if place >= self.marks[-1]:
            return self.corners[-1]
        index = bisect_right(self.marks, place) - 1
        start, end = self.marks[index], self.marks[index + 1]
        share = (place - start) / (end - start)
        pair = zip(self.corners[index], self.corners[index + 1], strict=True)
        return tuple([a + share * (b - a) for a, b in pair])

    def pieces(self, longest_s: float) -> tuple[Piece, ...]:
        """Return the motion in parts of constant speed, end to end, as a driver sends them.

        A part ends at every corner and, while the speed changes, after `longest_s` at most; at
        its end it is where the path is at that time.
        """
        if not longest_s > 0.0:
            raise KinematicsError(f"longest_s must be more than 0, not {longest_s!r}")
        made = []
        for corner, (begin_s, end_s) in zip(self.corners[1:], pairwise(self.times_s), strict=True):
            before_s = begin_s
            for cut_s in self._cuts_s(begin_s, end_s, longest_s):
                made.append(Piece(self.at(cut_s), cut_s - before_s))
                before_s = cut_s
            if end_s > before_s:
                made.append(Piece(corner, end_s - before_s))
            elif made:
                made[-1] = made[-1]._replace(point=corner)
        return tuple(made)

    def _cuts_s(self, begin_s: float, end_s: float, longest_s: float) -> Iterator[float]:
        """Yield the times within a chord at which a part ends."""
        shortest_s = SHORTEST * longest_s
        changing_s = begin_s
        index = bisect_right(self.profile.ends_s, begin_s)
        for phase, over_s in zip(
            self.profile.phases[index:], self.profile.ends_s[index:], strict=True
        ):
            from_s, to_s = max(over_s - phase.duration_s, begin_s), min(over_s, end_s)
            if from_s >= end_s:
                break
            if phase.steady and to_s - from_s > longest_s:
                yield from _even(changing_s, from_s, longest_s)
                if from_s - changing_s > shortest_s:
                    yield from_s
                if end_s - to_s > shortest_s:
                    yield to_s
                changing_s = to_s
        yield from _even(changing_s, end_s, longest_s)


def timed(
    corners: Sequence[Sequence[float]], limits: MotionLimits, speed: float = 1.0
) -> TimedPath:
    """Return the quickest motion along corners under limits, from rest to rest.

    `speed` is a fraction (above 0, up to 1) of the speed limits and motor rates; accelerations
    stay. A corner that repeats the one before takes no time. See above for what holds.
    """
    points = tuple(tuple(corner) for corner in corners)
    _check(points, limits, speed)
    changes = [
        tuple([b - a for a, b in zip(start, end, strict=True)]) for start, end in pairwise(points)
    ]
    least_s = [limits.least_s(change) / speed for change in changes]
    least_s = [each_s if each_s > INSTANT_S else 0.0 for each_s in least_s]
    marks = tuple(accumulate(least_s, initial=0.0))
    chords = [Chord(*both) for both in zip(least_s, changes, strict=True) if both[0] > 0.0]
    return TimedPath(points, marks, _profile(chords, marks[-1], limits))


def _profile(chords: list[Chord], length: float, limits: MotionLimits) -> Profile:
    """Return how the parameter runs: its speed is 1 at most."""
    build_s = limits.jerk_s
    if len(chords) < 2 or not limits.ramps:
        hardest = max((_hardness(chord, limits) for chord in chords if limits.ramps), default=0.0)
        slope = 1.0 / hardest if hardest > 0.0 else math.inf
        return jerk_limited(length, 1.0, slope, slope / build_s if build_s > 0.0 else math.inf)
    cells = cells_of(chords, limits.accelerations)
    if build_s == 0.0:
        return quickest(cells, length)
    return averaged(quickest(widened(cells, build_s), length), build_s)


def _hardness(chord: Chord, limits: MotionLimits) -> float:
    """Return how much of the most limited acceleration a straight way takes."""
    pairs = zip(chord.change, limits.accelerations, strict=True)
    return max(abs(change) / limit for change, limit in pairs) / chord.least_s


def _check(points: tuple[Point, ...], limits: MotionLimits, speed: float) -> None:
    if not points:
        raise KinematicsError("a path needs a point to begin at")
    if not 0.0 < finite("speed", speed) <= 1.0:
        raise KinematicsError(
            f"speed is a fraction of the limits, above 0 and up to 1, not {speed!r}"
        )
    count = len(limits.speeds)
    for point in points:
        if len(point) != count:
            raise KinematicsError(
                f"{count} coordinates have limits, so each corner needs {count}, not {len(point)}"
            )
        for value in point:
            finite("a corner's coordinate", value)


def _even(begin_s: float, end_s: float, longest_s: float) -> Iterator[float]:
    """Yield the times that cut a span evenly, its ends left out."""
    count = math.ceil((end_s - begin_s) / longest_s - ROUNDING)
    for index in range(1, count):
        yield begin_s + (end_s - begin_s) * index / count
