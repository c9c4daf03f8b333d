"""What an arm of the five-axis build reaches within its limits, in one vertical plane.

Lengths in mm, angles in rad. The section is the vertical plane through the base axis at one
azimuth, with the hand held at one pitch: x outwards (negative behind the axis), z up. Its
boundary is made of arcs of circles, the images of the joint limits and of the stretched arm
(`nearest.edges`), and of pieces of the base axis; of each, the pieces remain that have reach on one
side only.

Source: McKerrow, chapter 4, figures c of the two-link manipulators, for arms with limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.closed_form import Angles, nearest_branch
from kinematics.five_axis.nearest import Edge, edges, plane_pitches
from kinematics.frames.numbers import last_that
from kinematics.limits import JointRange

# How far to either side of a boundary its reach is asked; what is thinner is not seen.
NUDGE_MM = 0.02

# How often the end of a boundary is halved: from a step of 5 mm to a millionth of a mm.
_HALVINGS = 24

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Section:
    """What an arm reaches in a vertical plane through its base axis, at one pitch of the hand.

    `boundary` holds curves, each a row of points (x, z) not farther apart than asked for; `holds`
    tells of one place.
    """

    arm: FiveAxisArm
    pitch_rad: float
    azimuth_rad: float
    boundary: tuple[tuple[Point, ...], ...]

    def holds(self, x_mm: float, z_mm: float) -> bool:
        """Whether some posture within the limits brings the tip there, whatever the roll."""
        return _reach(self.arm, self.pitch_rad, self.azimuth_rad)(x_mm, z_mm)

    @property
    def box_mm(self) -> tuple[float, float, float, float]:
        """Least and greatest x, least and greatest z; all zero where nothing is reached."""
        points = [point for curve in self.boundary for point in curve] or [(0.0, 0.0)]
        xs, zs = zip(*points, strict=True)
        return min(xs), max(xs), min(zs), max(zs)

    def points(self, spacing_mm: float = 10.0) -> tuple[Point, ...]:
        """Return the places of a square lattice that are reached."""
        holds = _reach(self.arm, self.pitch_rad, self.azimuth_rad)
        low_x, high_x, low_z, high_z = self.box_mm
        return tuple(
            (x, z)
            for x in _lattice(low_x, high_x, spacing_mm)
            for z in _lattice(low_z, high_z, spacing_mm)
            if holds(x, z)
        )


def section(
    arm: FiveAxisArm, pitch_rad: float, azimuth_rad: float = 0.0, step_mm: float = 5.0
) -> Section:
    """Return what an arm reaches at a pitch in the vertical plane of an azimuth."""
    holds = _reach(arm, pitch_rad, azimuth_rad)
    curves = [curve for track in _tracks(arm, pitch_rad) for curve in _rims(track, holds, step_mm)]
    return Section(arm, pitch_rad, azimuth_rad, tuple(curves))


@lru_cache(maxsize=8)
def _reach(
    arm: FiveAxisArm, pitch_rad: float, azimuth_rad: float
) -> Callable[[float, float], bool]:
    """Return a function that says whether a place (x, z) of the section is reached."""
    any_roll = replace(arm, limits=(*arm.limits[:4], JointRange(-math.tau, math.tau)))
    near: Angles = (arm.limits[0].clamp(azimuth_rad), 0.0, 0.0, 0.0, 0.0)
    cosine, sine = math.cos(azimuth_rad), math.sin(azimuth_rad)

    def holds(x: float, z: float) -> bool:
        goal = (x * cosine, x * sine, z, pitch_rad, 0.0)
        return nearest_branch(goal, None, any_roll, near) is not None

    return holds


@dataclass(frozen=True, slots=True)
class _Track:
    """A candidate for a piece of the boundary: a place and its normal at a parameter."""

    at: Callable[[float], tuple[Point, Point]]
    low: float
    high: float
    length_mm: float


def _tracks(arm: FiveAxisArm, pitch_rad: float) -> Iterator[_Track]:
    """Yield the edges of tips before and behind the axis, both ways round, and the axis itself."""
    for side in (1, -1):
        for pitch in plane_pitches(arm, pitch_rad, side):
            for edge in edges(arm, pitch):
                yield from (_edge_track(arm, edge, mirrored) for mirrored in (1.0, -1.0))
    longest = sum(arm.lengths[1:])
    height = arm.base_height_mm
    yield _Track(lambda z: ((0.0, z), (1.0, 0.0)), height - longest, height + longest, 2 * longest)


def _edge_track(arm: FiveAxisArm, edge: Edge, mirrored: float) -> _Track:
    """Return an edge's tips. They run along a circle, so opposite tips have its diameter."""

    def at(t: float) -> tuple[Point, Point]:
        (r, z), (far_r, far_z) = (edge.tip(one, arm.lengths) for one in (t, t + math.pi))
        across = math.dist((r, z), (far_r, far_z)) or 1.0
        return (mirrored * r, z), (mirrored * (r - far_r) / across, (z - far_z) / across)

    radius = math.dist(*(edge.tip(one, arm.lengths) for one in (0.0, math.pi))) / 2.0
    return _Track(at, edge.low, edge.high, radius * (edge.high - edge.low))


def _rims(
    track: _Track, holds: Callable[[float, float], bool], step_mm: float
) -> Iterator[tuple[Point, ...]]:
    """Yield the pieces of a track that have reach on one side only, ends found by halving."""

    def is_rim(t: float) -> bool:
        (x, z), (out, up) = track.at(t)
        inner = holds(x - NUDGE_MM * out, z - NUDGE_MM * up)
        return inner != holds(x + NUDGE_MM * out, z + NUDGE_MM * up)

    count = max(math.ceil(track.length_mm / step_mm), 1)
    places = [track.low + (track.high - track.low) * (i + 0.5) / count for i in range(count)]
    found: list[float] = []
    before = track.low
    for t in places:
        if is_rim(t):
            if not found:
                found.append(last_that(is_rim, t, before, _HALVINGS))
            found.append(t)
        elif found:
            yield _piece(track, [*found, last_that(is_rim, found[-1], t, _HALVINGS)])
            found = []
        before = t
    if found:
        yield _piece(track, [*found, last_that(is_rim, found[-1], track.high, _HALVINGS)])


def _piece(track: _Track, parameters: Sequence[float]) -> tuple[Point, ...]:
    return tuple(track.at(t)[0] for t in parameters)


def _lattice(low: float, high: float, spacing: float) -> Iterator[float]:
    for index in range(math.floor(low / spacing), math.ceil(high / spacing) + 1):
        yield index * spacing
