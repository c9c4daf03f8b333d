"""What an arm reaches, as sketches: a section of a five-axis arm, or samples of any chain."""

from __future__ import annotations

import math

from armdrive.draw.sketch import Sketch
from kinematics.chains.chain import Chain
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.workspace import sampled_reach, section

_LATTICE = 24
_FINEST_MM = 5.0


def section_sketch(arm: FiveAxisArm, pitch_deg: float, azimuth_deg: float) -> Sketch:
    """Return the boundary and a lattice of the reach at a pitch, in the plane of an azimuth."""
    cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg))
    low, high, _, _ = cut.box_mm
    spacing = max((high - low) / _LATTICE, _FINEST_MM)
    return Sketch(cut.boundary, cut.points(spacing), "distance from the base axis", "height z")


def reach_sketches(chain: Chain) -> tuple[Sketch, Sketch]:
    """Return places that a chain's tool was brought to, from the side and from above."""
    points = sampled_reach(chain).points
    return (
        Sketch((), tuple((x, z) for x, _, z in points), "x", "z"),
        Sketch((), tuple((x, y) for x, y, _ in points), "x", "y"),
    )
