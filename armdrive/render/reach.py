"""The outline of an arm's reach as lines in the arm's plane; slow to compute, therefore cached.

A five-axis arm of the Mini-mover type has an exact outline for each pitch of the hand. For any
other arm, many postures are sampled, and the outline is the greatest distance of the tip at each
height, at any pitch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.render.inks import Ink, Layer, Stroke
from armdrive.render.sketch import Sketch
from kinematics.chains.chain import Chain
from kinematics.chains.reach import spread_over
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.workspace import section
from kinematics.geometry import ArmGeometry, Point
from kinematics.spaces import Joints

PITCH_DEG = 5  # the outline is computed for the nearest multiple of this pitch
AZIMUTH_DEG = 15
"""The same for the azimuth, because the base's limits restrict the reach behind its axis."""

_STEP_MM = 20.0  # length of chords; on the smallest arc of an arm they are within 1 mm of it

_POSTURES = 3000
_LEVELS = 24

Key = tuple[int, int]
"""Pitch and azimuth in degrees; always (0, 0) for an arm with a single outline."""


@dataclass(frozen=True, slots=True)
class Outline:
    """Curves of (distance from the base axis, height) in mm, and a description for the legend."""

    curves: tuple[tuple[tuple[float, float], ...], ...]
    words: str


def key_of(arm: ArmGeometry, pitch_rad: float, azimuth_rad: float) -> Key:
    """Return the key of a posture's outline; similar postures share one."""
    if not isinstance(arm, FiveAxisArm):
        return 0, 0
    return _nearest(pitch_rad, PITCH_DEG), _nearest(azimuth_rad, AZIMUTH_DEG)


def outline(arm: ArmGeometry, key: Key) -> Outline:
    """Compute an outline. Takes some hundredths of a second: do not call on the screen's thread."""
    pitch_deg, azimuth_deg = key
    if isinstance(arm, FiveAxisArm):
        cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg), _STEP_MM)
        return Outline(cut.boundary, f"reach at pitch {pitch_deg}")
    return Outline((_farthest(arm),), "reach at any pitch")


def in_plane(of: Outline, centre: Point, azimuth_rad: float) -> Layer:
    """Return an outline in the vertical plane through the base axis at an azimuth."""
    cosine, sine = math.cos(azimuth_rad), math.sin(azimuth_rad)
    x, y, _ = centre
    strokes = tuple(
        Stroke(Ink.REACH, tuple((x + r * cosine, y + r * sine, z) for r, z in curve))
        for curve in of.curves
    )
    return Layer(strokes)


def _nearest(angle_rad: float, step_deg: int) -> int:
    return round(math.degrees(angle_rad) / step_deg) * step_deg


def _farthest(arm: ArmGeometry) -> tuple[tuple[float, float], ...]:
    """Return the farthest sampled point of the tip at each level, from the lowest up.

    Distances are measured from the base axis. Every call samples the same postures.
    """
    spans = [(one.low_rad, one.high_rad) for one in arm.limits]
    tips = [_tip(arm, angles) for angles in spread_over(spans, _POSTURES).postures()]
    heights = [z for _, z in tips]
    low, high = min(heights), max(heights)
    size = max((high - low) / _LEVELS, 1e-9)
    best: dict[int, tuple[float, float]] = {}
    for r, z in tips:
        level = min(int((z - low) / size), _LEVELS - 1)
        if level not in best or r > best[level][0]:
            best[level] = (r, z)
    return tuple(best[level] for level in sorted(best))


def _tip(arm: ArmGeometry, angles: tuple[float, ...]) -> tuple[float, float]:
    points = arm.points(Joints(angles, arm.joint_names))
    return math.hypot(points[-1][0] - points[0][0], points[-1][1] - points[0][1]), points[-1][2]


# --- Sketches of the reach: a section of a five-axis arm, or samples of any chain ----------------

_LATTICE = 24
_FINEST_MM = 5.0

_MAPPED = 1_000_000  # sampled postures of a map: half a second, without gaps on a printed page
_CELLS = 120  # cells along the larger side of a map; each shows at most one point


def section_sketch(arm: FiveAxisArm, pitch_deg: float, azimuth_deg: float) -> Sketch:
    """Return the boundary of the reach and a lattice of points in it, at a pitch and an azimuth."""
    cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg))
    low, high, _, _ = cut.box_mm
    spacing = max((high - low) / _LATTICE, _FINEST_MM)
    return Sketch(cut.boundary, cut.points(spacing), "distance from the base axis", "height z")


def reach_sketches(chain: Chain) -> tuple[Sketch, Sketch]:
    """Return a map of the positions that a chain's tool reaches, from the side and from above."""
    from kinematics.chains.many import reach_maps  # loads numpy, which the desk does without

    maps = reach_maps(chain, ((0, 2), (0, 1)), _MAPPED, _CELLS)
    side, above = (tuple((float(x), float(y)) for x, y in places) for places in maps)
    return Sketch((), side, "x", "z"), Sketch((), above, "x", "y")
