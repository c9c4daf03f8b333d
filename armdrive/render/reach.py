"""How far an arm reaches, as lines in space: worked out seldom, kept, and drawn in the arm's plane.

An arm of the Mini-mover's build has an exact outline at each pitch of the hand; of any other, many
postures are tried, and the outline is the farthest that its tip came at each height, at any pitch.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.render.inks import Ink, Layer, Stroke
from armdrive.render.sketch import Sketch
from kinematics.chains.chain import Chain
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.workspace import section
from kinematics.geometry import ArmGeometry, Point
from kinematics.spaces import Joints

PITCH_DEG = 5
"""The outline is worked out for the nearest multiple of this pitch."""

AZIMUTH_DEG = 15
"""What is reached behind the base axis depends on where the base can turn to: as coarsely."""

_STEP_MM = 20.0
"""On the smallest arc of an arm, chords of this length stay within 1 mm of it."""

_POSTURES = 3000
_LEVELS = 24

Key = tuple[int, int]
"""Pitch and azimuth in degrees; the only key of an arm that has one outline is (0, 0)."""


@dataclass(frozen=True, slots=True)
class Outline:
    """Curves of (distance from the base axis, height) in mm, and what they hold for, in words."""

    curves: tuple[tuple[tuple[float, float], ...], ...]
    words: str


def key_of(arm: ArmGeometry, pitch_rad: float, azimuth_rad: float) -> Key:
    """Return which outline belongs to a posture; the same for many postures alike."""
    if not isinstance(arm, FiveAxisArm):
        return 0, 0
    return _nearest(pitch_rad, PITCH_DEG), _nearest(azimuth_rad, AZIMUTH_DEG)


def outline(arm: ArmGeometry, key: Key) -> Outline:
    """Work an outline out. Takes some hundredths of a second: not for where somebody waits."""
    pitch_deg, azimuth_deg = key
    if isinstance(arm, FiveAxisArm):
        cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg), _STEP_MM)
        return Outline(cut.boundary, f"reach at pitch {pitch_deg}")
    return Outline((_farthest(arm),), "reach at any pitch")


def in_plane(of: Outline, centre: Point, azimuth_rad: float) -> Layer:
    """Return an outline in the upright plane through the base axis at an azimuth."""
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
    """Return the farthest that the tip came in each of some levels, from the lowest up.

    The distance is counted from the axis of the base; the postures are the same at every call.
    """
    draw = random.Random(1)  # noqa: S311 - any postures will do
    tips = [_tip(arm, [draw.uniform(*bounds) for bounds in _bounds(arm)]) for _ in range(_POSTURES)]
    heights = [z for _, z in tips]
    low, high = min(heights), max(heights)
    size = max((high - low) / _LEVELS, 1e-9)
    best: dict[int, tuple[float, float]] = {}
    for r, z in tips:
        level = min(int((z - low) / size), _LEVELS - 1)
        if level not in best or r > best[level][0]:
            best[level] = (r, z)
    return tuple(best[level] for level in sorted(best))


def _bounds(arm: ArmGeometry) -> list[tuple[float, float]]:
    return [(one.low_rad, one.high_rad) for one in arm.limits]


def _tip(arm: ArmGeometry, angles: Sequence[float]) -> tuple[float, float]:
    points = arm.points(Joints(tuple(angles), arm.joint_names))
    return math.hypot(points[-1][0] - points[0][0], points[-1][1] - points[0][1]), points[-1][2]


# --- Sketches of the reach: a section of a five-axis arm, or samples of any chain ----------------

_LATTICE = 24
_FINEST_MM = 5.0

_MAPPED = 1_000_000
"""Postures in a map of the reach: some half a second, and no gap at the resolution of a page."""

_CELLS = 120
"""Cells along the larger side of a map, of which each shows one place at most."""


def section_sketch(arm: FiveAxisArm, pitch_deg: float, azimuth_deg: float) -> Sketch:
    """Return the boundary and a lattice of the reach at a pitch, in the plane of an azimuth."""
    cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg))
    low, high, _, _ = cut.box_mm
    spacing = max((high - low) / _LATTICE, _FINEST_MM)
    return Sketch(cut.boundary, cut.points(spacing), "distance from the base axis", "height z")


def reach_sketches(chain: Chain) -> tuple[Sketch, Sketch]:
    """Return places that a chain's tool was brought to, from the side and from above."""
    from kinematics.chains.many import reach_maps  # loads numpy, which the desk does without

    maps = reach_maps(chain, ((0, 2), (0, 1)), _MAPPED, _CELLS)
    side, above = (tuple((float(x), float(y)) for x, y in places) for places in maps)
    return Sketch((), side, "x", "z"), Sketch((), above, "x", "y")
