"""Timing of paths: the quickest motion along chords within all speed and acceleration limits.

Coordinates are joints in rad and, if the gripper moves, its opening in mm; times are in s. A path
is passed from rest to rest without stopping. Its shape never changes: near a singularity, where a
joint turns fast, the motion slows down.

Two corners are one straight motion, with all coordinates in proportion, timed exactly. More corners
stand for a smooth curve (a straight line of the tip, an arc, a blend) cut into chords. (Where a
corner is meant to be sharp, stop there, or blend it.) Tests confirm these guarantees:

- No coordinate and no motor ever exceeds its speed limit.
- No acceleration limit is exceeded if the curve's direction turns evenly from the middle of each
  chord to the middle of the next. The chords' own speeds jump at a corner by what this turn makes
  up between two middles: the finer the chords, the smaller the jumps.
- With a build-up time the same holds. The acceleration along the path then changes by its limit in
  no less than that time, or half of it where speeding up turns straight into braking.

Without any acceleration limit, each chord takes its least time at full speed, and the build-up time
has no effect.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from math import sqrt
from operator import mul
from typing import NamedTuple

from kinematics.errors import KinematicsError, finite, not_negative, positive
from kinematics.paths.profiles import Phase, Profile, averaged, trapezoid
from kinematics.text import counted

# The limits of a timed path: those of every coordinate, and of every motor after the couplings.

Point = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Limits of each coordinate (per s, per s^2), and of all motors (steps/s).

    `accelerations` may be infinite, and are by default. `jerk_s` is the time in which an
    acceleration builds up; 0 lets it jump. `motors` holds a row for each motor, its steps per unit
    of each coordinate: a transmission's `matrix`. Raises `KinematicsError` and `BadNumber`.
    """

    speeds: tuple[float, ...]
    accelerations: tuple[float, ...] = ()
    jerk_s: float = 0.0
    motors: tuple[tuple[float, ...], ...] = ()
    motor_hz: float = math.inf

    def __post_init__(self) -> None:
        count = len(self.speeds)
        if not self.accelerations:
            object.__setattr__(self, "accelerations", (math.inf,) * count)
        for speed in self.speeds:
            positive("a speed limit", speed)
        for acceleration in self.accelerations:
            positive("an acceleration limit", acceleration, endless=True)
        positive("motor_hz", self.motor_hz, endless=True)
        not_negative("jerk_s", self.jerk_s)
        if any(len(row) != count for row in (self.accelerations, *self.motors)):
            raise KinematicsError(
                f"{counted(count, 'coordinate has', 'coordinates have')} a speed limit, so "
                "as many accelerations are needed, "
                "and as many numbers in each motor's row"
            )

    @property
    def ramps(self) -> bool:
        """Whether anything takes time to reach its speed."""
        return any(limit < math.inf for limit in self.accelerations)

    def least_s(self, change: Sequence[float]) -> float:
        """Return the least time for a straight motion: at full speed, within every limit."""
        slowest = max(map(_share, change, self.speeds))
        busiest = max((abs(sum(map(mul, row, change))) for row in self.motors), default=0.0)
        return max(slowest, busiest / self.motor_hz)


def _share(change: float, limit: float) -> float:
    return abs(change) / limit


# The share of the acceleration limits that each part of a path uses: the limits of its parameter,
# cell by cell.
#
# The parameter is the time that the path takes at full speed, so its own speed is 1 wherever a
# speed is at its limit. The corners stand for a smooth curve, whose direction is assumed to turn
# evenly from the middle of each chord to the middle of the next. The stretch in between, a cell,
# has constant curvature. In a cell, a parameter of speed v and acceleration a keeps coordinate i
# within its limit if weight_i * |a| + bend_i * v^2 <= 1.


class TimedChord(NamedTuple):
    """A straight part of a path: its least time, and its displacement."""

    least_s: float
    change: Point


class Cell(NamedTuple):
    """From the middle of one chord to the next one's: its length, and the load per coordinate."""

    length: float
    weights: Point
    bends: Point


def cells_of(chords: Sequence[TimedChord], accelerations: Sequence[float]) -> list[Cell]:
    """Return a cell for each corner and half a chord at each end, without unlimited coordinates."""
    bounded = [(index, limit) for index, limit in enumerate(accelerations) if limit < math.inf]
    shares = [
        [chord.change[index] / (chord.least_s * limit) for index, limit in bounded]
        for chord in chords
    ]
    sizes = [tuple(map(abs, share)) for share in shares]
    straight = (0.0,) * len(bounded)
    cells = [Cell(chords[0].least_s / 2.0, sizes[0], straight)]
    for index in range(1, len(chords)):
        length = 0.5 * (chords[index - 1].least_s + chords[index].least_s)
        bends = [abs(b - a) / length for a, b in zip(shares[index - 1], shares[index], strict=True)]
        cells.append(Cell(length, tuple(map(max, sizes[index - 1], sizes[index])), tuple(bends)))
    cells.append(Cell(chords[-1].least_s / 2.0, sizes[-1], straight))
    return cells


def widened(cells: Sequence[Cell], window: float) -> list[Cell]:
    """Return cells that also keep the limits of everything nearer than `window`.

    Long cells are cut first, so that the neighbourhood of their ends does not affect all of them.
    """
    ends = list(accumulate(cell.length for cell in cells))
    starts = [0.0, *ends[:-1]]
    slack = 1e-9 * window  # cells that only touch are not neighbours
    made = []
    end = 0.0
    first = last = 0
    for cell in cells:
        for length in _cut(cell.length, window):
            start, end = end, end + length
            while ends[first] <= start - window + slack:
                first += 1
            while last < len(cells) and starts[last] < end + window - slack:
                last += 1
            made.append(_hardest(length, cells[first:last]))
    return made


def _cut(length: float, window: float) -> tuple[float, ...]:
    if length <= 2.0 * window:
        return (length,)
    return window, length - 2.0 * window, window


def _hardest(length: float, cells: Sequence[Cell]) -> Cell:
    """Return a cell of this length that is as hard on each coordinate as any of these."""
    if len(cells) == 1:
        return Cell(length, cells[0].weights, cells[0].bends)
    _, weights, bends = zip(*cells, strict=True)
    return Cell(length, tuple(map(max, *weights)), tuple(map(max, *bends)))


# The quickest profile of a path's parameter through its cells: a forward pass, then a backward one.
#
# The parameter's speed is at most 1. Squared speed changes linearly along the path under constant
# acceleration. Where a cell bends, the share of the acceleration that the bend uses is assumed
# always to add to speeding up or braking; so no limit is exceeded, and a little speed is given away
# in curves, and where speeding up ends.
#
# Source: the passes are those of Kunz and Stilman, Time-Optimal Trajectory Generation for Path
# Following with Bounded Acceleration and Velocity (RSS 2012), with the two terms of an acceleration
# kept apart, so that the path is passable everywhere.

# The longest part of a cell, in s at full speed, in which the acceleration is constant: speeding up
# and braking end with such a part.
FINEST_S = 0.02


def quickest(cells: Sequence[Cell], whole: float) -> Profile:
    """Return the profile of the parameter over all cells, whose lengths add up to the whole."""
    parts: list[Cell] = []
    for cell in cells:
        count = math.ceil(cell.length / FINEST_S)
        parts += [cell._replace(length=cell.length / count)] * count
    caps = [1.0 / max(1.0, *part.bends) for part in parts]  # of the squared speed
    borders = [0.0, *map(min, caps, caps[1:]), 0.0]
    _pass(parts, borders)
    borders.reverse()
    _pass(parts[::-1], borders)
    borders.reverse()
    phases: list[Phase] = []
    distance = 0.0
    for part, (before, behind) in zip(parts, pairwise(borders), strict=True):
        start, change = sqrt(before), 0.5 * (behind - before) / part.length
        duration_s = 2.0 * part.length / (start + sqrt(behind))
        if phases and phases[-1].steady and change == 0.0:
            phases[-1] = phases[-1]._replace(duration_s=phases[-1].duration_s + duration_s)
        else:
            phases.append(Phase(duration_s, distance, start, change, 0.0))
        distance += part.length
    return Profile(tuple(phases), whole)


def _pass(cells: Iterable[Cell], borders: list[float]) -> None:
    """Lower each border to what the acceleration from the previous one allows."""
    square = borders[0]
    for index, (length, weights, bends) in enumerate(cells, 1):
        if square >= borders[index]:
            square = borders[index]
            continue
        double = 2.0 * length
        gain = math.inf
        for weight, bend in zip(weights, bends, strict=True):
            under = weight + double * bend  # the bend counts at the faster end
            if under > 0.0:
                gain = min(gain, (1.0 - bend * square) / under)
        square = min(borders[index], square + double * max(gain, 0.0))
        borders[index] = square


# A chord that takes less than this at full speed takes no time: its corners differ by rounding.
INSTANT_S = 1e-9

# Pieces of constant speed are not cut shorter than this share of the longest piece.
SHORTEST = 0.01

# By how much, as a share of itself, a longest piece may be exceeded.
ROUNDING = 1e-9


class Piece(NamedTuple):
    """A straight part of a motion at constant speed: where it ends, and how long it takes."""

    point: Point
    duration_s: float


@dataclass(frozen=True, slots=True)
class TimedPath:
    """Corners joined by straight chords, and the time at which each is passed.

    `marks` are the corners' places on the path's parameter, which `profile` traverses.
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
        """Return the point at a time; at both ends and beyond, exactly the corners."""
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

        A part ends at every corner and, while the speed changes, after `longest_s` at most; at its
        end it is where the path is at that time.
        """
        positive("longest_s", longest_s, endless=True)
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

    `speed` is a fraction (above 0, up to 1) of the speed limits and motor rates; accelerations are
    not scaled. A corner that repeats the previous one takes no time. The module's docstring states
    the guarantees.
    """
    points = tuple(tuple(corner) for corner in corners)
    _check(points, limits, speed)
    changes = [
        tuple([b - a for a, b in zip(start, end, strict=True)]) for start, end in pairwise(points)
    ]
    least_s = [limits.least_s(change) / speed for change in changes]
    least_s = [each_s if each_s > INSTANT_S else 0.0 for each_s in least_s]
    marks = tuple(accumulate(least_s, initial=0.0))
    chords = [TimedChord(*both) for both in zip(least_s, changes, strict=True) if both[0] > 0.0]
    return TimedPath(points, marks, _profile(chords, marks[-1], limits))


def _profile(chords: list[TimedChord], length: float, limits: MotionLimits) -> Profile:
    """Return the profile of the parameter, whose speed is at most 1."""
    build_s = limits.jerk_s if limits.ramps else 0.0
    if len(chords) < 2 or not limits.ramps:
        hardest = max((_hardness(chord, limits) for chord in chords if limits.ramps), default=0.0)
        profile = trapezoid(length, 1.0, 1.0 / hardest if hardest > 0.0 else math.inf)
    else:
        cells = cells_of(chords, limits.accelerations)
        profile = quickest(widened(cells, build_s) if build_s else cells, length)
    return averaged(profile, build_s) if build_s and profile.phases else profile


def _hardness(chord: TimedChord, limits: MotionLimits) -> float:
    """Return how much of the most limited acceleration a straight motion takes."""
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
                f"{counted(count, 'coordinate has', 'coordinates have')} limits, so each "
                f"corner needs {count}, not {len(point)}"
            )
        for value in point:
            finite("a corner's coordinate", value)


def _even(begin_s: float, end_s: float, longest_s: float) -> Iterator[float]:
    """Yield the times that divide a span evenly, without its ends."""
    count = math.ceil((end_s - begin_s) / longest_s - ROUNDING)
    for index in range(1, count):
        yield begin_s + (end_s - begin_s) * index / count
