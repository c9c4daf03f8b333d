"""A straight line of the tip, or any curve, cut into short joint motions.

Units: mm and rad. Between two corners every joint turns in proportion: a chord of the curve in
joint space, short enough for the accuracy of the tip and for timing. Timing judges how a path bends
by how much the direction of one chord differs from the next, so neighbouring directions must be
similar. A straight line is solved on one branch of the inverse kinematics.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from operator import mul, sub
from typing import NamedTuple

from kinematics.errors import positive
from kinematics.geometry import ArmGeometry, Curve, PathBroken
from kinematics.paths.curves import straight_line
from kinematics.spaces import Joints, Pose

# Share of the tolerance allowed at the sampled points, so that it holds between them too.
#
# Between two corners the deviation is close to a parabola that is zero at both ends. Samples at a
# quarter, a half and three quarters find its top, and the margin covers the remaining error.
MARGIN = 0.75

# The smallest share of a curve between two corners; a curve that needs smaller ones breaks.
SHORTEST_CUT = 2.0**-16

# The most that a path's direction in joint space turns at a corner, unless its chords are tiny.
LARGEST_CORNER_RAD = math.radians(15.0)

# A chord in which the joints turn by less is tiny: about a motor step of a table-top arm.
TINY_RAD = 1e-3

# A chord in which the joints turn by less than this has no direction.
STILL_RAD = 1e-9

_SHARES = (0.25, 0.5, 0.75)
_COSINE = math.cos(LARGEST_CORNER_RAD)


class Chord(NamedTuple):
    """A joint motion from `start` to `end` that replaces a curve between two of its shares."""

    curve: Curve
    low: float
    high: float
    start: Joints
    end: Joints


def cut(arm: ArmGeometry, curve: Curve, start: Joints, tolerance_mm: float) -> list[Chord]:
    """Return the chords of a whole curve, given its first posture.

    With the joints turning in proportion, the tip is never further than `tolerance_mm` from the
    point of the curve at the same fraction. Raises `PathBroken` if the curve cannot be followed.
    """
    tolerance = positive("tolerance_mm", tolerance_mm) * MARGIN
    if curve.straight:
        return [Chord(curve, 0.0, 1.0, start, curve.solve(1.0, start))]
    count = curve.least_chords
    ahead = [index / count for index in range(count, 0, -1)]
    found: list[Chord] = []
    low = 0.0
    while ahead:
        high = ahead[-1]
        reached = _step(arm, curve, low, start, high, tolerance)
        if isinstance(reached, Joints):
            found.append(Chord(curve, low, high, start, reached))
            low, start = high, reached
            ahead.pop()
        elif high - low > SHORTEST_CUT:
            ahead.append((low + high) / 2.0)
        elif isinstance(reached, PathBroken):
            raise reached
        else:
            raise PathBroken(high, curve.pose(high), reached, shape=curve.shape)
    return found


def _step(
    arm: ArmGeometry, curve: Curve, low: float, start: Joints, high: float, tolerance: float
) -> Joints | PathBroken | str:
    """Return the posture at `high` if one joint motion may lead there; otherwise the reason."""
    try:
        reached = curve.solve(high, start)
    except PathBroken as broken:
        return broken
    leap = curve.leap(start, reached)
    if leap is not None:
        return leap
    a, names = start.angles_rad, start.names
    changes = tuple(map(sub, reached.angles_rad, a))
    for share in _SHARES:
        between = tuple([angle + share * change for angle, change in zip(a, changes, strict=True)])
        tip = arm.points(Joints(between, names))[-1]
        missed = math.dist(tip, curve.tip(low + share * (high - low)))
        if missed > tolerance:
            return f"the tip would leave the {curve.shape} by {missed:.2f} mm"
    return reached


def smooth(chords: Sequence[Chord]) -> list[Chord]:
    """Halve chords until no corner between two of them turns by more than `LARGEST_CORNER_RAD`.

    Of a corner's two chords the longer is halved, and the shorter too unless it is less than half
    as long. Chords of less than `TINY_RAD` stay, so that a curve may have a cusp.
    """
    found = list(chords)
    while True:
        sharp = _sharp(found)
        if not sharp:
            return found
        halved: list[Chord] = []
        for index, chord in enumerate(found):
            halved.extend(_halves(chord) if index in sharp else (chord,))
        found = halved


def _sharp(chords: Sequence[Chord]) -> set[int]:
    """Return which chords must be halved."""
    if len(chords) < 2:
        return set()
    ways = [tuple(map(sub, chord.end.angles_rad, chord.start.angles_rad)) for chord in chords]
    lengths = [math.hypot(*way) for way in ways]
    found = set()
    for index, ((one, two), (a, b)) in enumerate(
        zip(pairwise(ways), pairwise(lengths), strict=True)
    ):
        if sum(map(mul, one, two)) >= _COSINE * a * b or min(a, b) <= STILL_RAD:
            continue
        if a > TINY_RAD and 2.0 * a > b:
            found.add(index)
        if b > TINY_RAD and 2.0 * b > a:
            found.add(index + 1)
    return found


def _halves(chord: Chord) -> tuple[Chord, Chord]:
    curve, low, high, start, end = chord
    middle = (low + high) / 2.0
    between = curve.solve(middle, start)
    return Chord(curve, low, middle, start, between), Chord(curve, middle, high, between, end)


def trim(chords: Sequence[Chord], low: float, high: float) -> list[Chord]:
    """Return the chords of a curve between two shares of its length."""
    found = []
    for chord in chords:
        first, last = max(chord.low, low), min(chord.high, high)
        if last - first <= SHORTEST_CUT * STILL_RAD:
            continue
        start = chord.start if first == chord.low else chord.curve.solve(first, chord.start)
        end = chord.end if last == chord.high else chord.curve.solve(last, start)
        found.append(Chord(chord.curve, first, last, start, end))
    return found


def posture_at(chords: Sequence[Chord], share: float) -> Joints:
    """Return the posture at a share of a curve that has been cut completely."""
    for chord in chords:
        if share < chord.high:
            return chord.curve.solve(share, chord.start) if share > chord.low else chord.start
    return chords[-1].end


def corners(chords: Sequence[Chord]) -> tuple[Joints, ...]:
    """Return the postures at the ends of the chords, in order."""
    return (chords[0].start, *(chord.end for chord in chords))


# The default tolerance of a straight line: less than two steps of a TeachMover.
LINE_TOLERANCE_MM = 0.5


def line_path(
    arm: ArmGeometry, start: Joints, goal: Pose, tolerance_mm: float = LINE_TOLERANCE_MM
) -> tuple[Joints, ...]:
    """Return waypoints, including the start, of a straight line from a posture to a pose.

    The path is straight in x, y, z, pitch and roll. Pitch takes the shorter way round, and so does
    roll unless the wrist's range forbids it. All waypoints are on the start's branch. With the
    joints turning in proportion between waypoints, the tip is never further than `tolerance_mm`
    from the point of the line at the same fraction; pitch and roll, being sums of joint angles, are
    exact. At a waypoint the direction in joint space turns by at most 15 degrees. Raises
    `PathBroken` where the reach, a limit, or the branch ends. A joint that starts beyond its limit
    may come back, but not go further.
    """
    return corners(smooth(cut(arm, straight_line(arm, start, goal), start, tolerance_mm)))
