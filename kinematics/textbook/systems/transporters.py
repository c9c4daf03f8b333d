"""The four transporters: cartesian, cylindrical, spherical and general revolute, all solutions.

Source: "Vectors and frames", chapter 2, section 2.5.2, equations 2.28 to 2.35. The notes' frames
start parallel to the base frame, so each hand's frame here is the base frame in the zero position.
They position and do not turn: the goal is the end point. Lengths in mm, angles in rad; ranges and
lengths are examples, since the source gives none.
"""

from __future__ import annotations

import math
from types import MappingProxyType

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink, JointKind
from kinematics.frames.numbers import atan2, sqrt
from kinematics.frames.transforms import transform
from kinematics.frames.vectors import ZERO
from kinematics.textbook.systems.named import (
    ENDLESS,
    ON_AXIS,
    QUARTER_TURN,
    NamedSingularity,
    Quantity,
    Solved,
    System,
    Values,
)
from kinematics.textbook.systems.triangle import elbow_singularities, to_half_turn, triangle
from kinematics.textbook.systems.two_link import ONLY, REACHES

END_POINT = ("x_mm", "y_mm", "z_mm")
TRAVEL = (0.0, 500.0)
DRAWN_IN = "the slide is drawn in: turning moves the tip no longer"
_SLIDE = JointKind.PRISMATIC

# A frame whose x, y and z point along the reference's y, z and x: a first joint along x.
X_UP = transform(((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), ZERO)

# A frame whose x, y and z point along the reference's z, x and y: a last joint along x.
X_LAST = transform(((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)), ZERO)

# A frame whose x, y and z point along the reference's z, against its y, and along its x.
UPRIGHT = transform(((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)), ZERO)

# Three prismatic joints along x, y and z (figure 2.14).
CARTESIAN = System(
    name="cartesian",
    coordinates=END_POINT,
    signs=ONLY,
    ranges=(TRAVEL, TRAVEL, TRAVEL),
    table=lambda: Chain(  # twice 90 degrees of angle and twist, which permute the axes
        (
            DHLink(QUARTER_TURN, alpha_rad=QUARTER_TURN, kind=_SLIDE),
            DHLink(QUARTER_TURN, alpha_rad=QUARTER_TURN, kind=_SLIDE),
            DHLink(kind=_SLIDE),
        ),
        base=X_UP,
        joint_names=("d1", "d2", "d3"),
    ),
    formulas=lambda _, goal: (goal, ()),
)


def _cylindrical_formulas(_one: System, goal: Values, side: float) -> Solved:
    x, y, z = goal
    out = side * sqrt(x * x + y * y)
    return (atan2(side * y, side * x), z, out), (Quantity("r", out, "mm"),)


# A revolute joint, a lift and a radial slide (figure 2.15, equations 2.28 to 2.32).
#
# The figure is captioned "A cartesian arm", and the letter l is printed as 1 in (2.30) and (2.32).
CYLINDRICAL = System(
    name="cylindrical",
    coordinates=END_POINT,
    signs=REACHES,
    ranges=(ENDLESS, TRAVEL, TRAVEL),
    table=lambda: Chain(  # 90 degrees of angle and twist before r
        (
            DHLink(),
            DHLink(QUARTER_TURN, alpha_rad=QUARTER_TURN, kind=_SLIDE),
            DHLink(kind=_SLIDE),
        ),
        tool=X_LAST,
        joint_names=("theta", "l", "r"),
    ),
    formulas=_cylindrical_formulas,
    singularities=lambda _, joints: [NamedSingularity(ON_AXIS, None, abs(joints[2]))],
)


def _spherical_formulas(_one: System, goal: Values, reach: float, top: float) -> Solved:
    x, y, z = goal
    r = reach * sqrt(x * x + y * y + z * z)
    out = top * sqrt(x * x + y * y)
    side = reach * top
    workings = (Quantity("r", r, "mm"), Quantity("|r| cos(theta)", out, "mm"))
    return (atan2(side * y, side * x), atan2(reach * z, out), r), workings


def _spherical_singularities(_one: System, joints: Values) -> list[NamedSingularity]:
    _, theta, r = joints
    return [
        NamedSingularity(ON_AXIS, to_half_turn(theta - math.pi / 2.0), abs(r * math.cos(theta))),
        NamedSingularity(DRAWN_IN, None, abs(r)),
    ]


# Azimuth, elevation and a slide from the origin (figure 2.16, equations 2.33 and 2.34).
SPHERICAL = System(
    name="spherical",
    coordinates=END_POINT,
    signs=MappingProxyType(
        {
            "reaching forward": (1.0, 1.0),
            "reaching forward, over the top": (1.0, -1.0),
            "reaching backward": (-1.0, 1.0),
            "reaching backward, over the top": (-1.0, -1.0),
        }
    ),
    ranges=(ENDLESS, ENDLESS, TRAVEL),
    table=lambda: Chain(
        (
            DHLink(alpha_rad=QUARTER_TURN),
            DHLink(alpha_rad=QUARTER_TURN, offset=QUARTER_TURN),
            DHLink(kind=_SLIDE),
        ),
        tool=UPRIGHT,
        joint_names=("phi", "theta", "r"),
    ),
    formulas=_spherical_formulas,
    singularities=_spherical_singularities,
)

# The general revolute transporter: three revolute joints, up to four solutions (section 2.5.2,
# figure 2.17 and equation 2.35). The links stand upright in the zero position.


def _revolute_formulas(one: System, goal: Values, side: float, bend: float) -> Solved:
    (l1, l2, l3), (x, y, z) = one.sizes, goal
    lean = side * sqrt(x * x + y * y)
    solved = triangle(z - l1, lean, l2, l3, bend)
    joints = (atan2(side * x, -(side * y)), solved.first, solved.second)
    return joints, (Quantity("h", lean, "mm"), *solved.workings())


def _revolute_singularities(one: System, joints: Values) -> list[NamedSingularity]:
    (_, l2, l3), (_, second, third) = one.sizes, joints
    lean = math.sin(second) * l2 + math.sin(second + third) * l3
    return [*elbow_singularities(third, l2, l3), NamedSingularity(ON_AXIS, None, abs(lean))]


# A turning column L1, an upper arm L2 and a forearm L3.
REVOLUTE = System(
    name="revolute",
    coordinates=END_POINT,
    signs=MappingProxyType(
        {
            "base front, elbow up": (1.0, 1.0),
            "base front, elbow down": (1.0, -1.0),
            "base back, elbow up": (-1.0, -1.0),
            "base back, elbow down": (-1.0, 1.0),
        }
    ),
    length_names=("L1", "L2", "L3"),
    sizes=(200.0, 180.0, 140.0),
    table=lambda l1, l2, l3: Chain(  # 90 degrees of offset bring the zero position upright
        (
            DHLink(d_mm=l1, alpha_rad=QUARTER_TURN, offset=QUARTER_TURN),
            DHLink(a_mm=l2, offset=QUARTER_TURN),
            DHLink(a_mm=l3),
        ),
        tool=UPRIGHT,
        joint_names=("theta1", "theta2", "theta3"),
    ),
    formulas=_revolute_formulas,
    singularities=_revolute_singularities,
)
