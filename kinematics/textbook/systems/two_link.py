"""The planar arms of the notes: the five two-link manipulators, and Craig's three-link one.

Source: McKerrow, chapter 4, sections 5 to 9; inverse solutions by section 11. Craig, chapter 3
(frames attached at the near end of each link) and chapter 4 (its inverse), for the three-link arm,
whose goal is the tip and the direction of the last link. The notes give neither lengths nor ranges:
the defaults are examples. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from types import MappingProxyType

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.frames.numbers import atan2, cos, sin, sqrt
from kinematics.frames.transforms import position_of, translation
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
from kinematics.textbook.systems.triangle import (
    ELBOWS,
    elbow_singularities,
    root,
    to_half_turn,
    triangle,
)

LEVEL = "the link is level: the tip cannot move along it, and arm up and arm down are one"
ONLY = MappingProxyType({"only solution": ()})
REACHES = MappingProxyType({"reaching forward": (1.0,), "reaching backward": (-1.0,)})
_SLIDE = JointKind.PRISMATIC
_THETAS = ("theta1", "theta2", "theta3")

# Type 1 (sections 5, 7 and 8): two parallel revolute joints.


def _type_1_formulas(one: System, goal: Values, side: float) -> Solved:
    (l1, l2), (x, y) = one.sizes, goal
    solved = triangle(x, y, l1, l2, side)
    return (solved.first, solved.second), solved.workings()


def _type_1_space(one: System) -> str:
    l1, l2 = one.sizes
    return f"a ring in the plane z = 0, {abs(l1 - l2):g} mm to {l1 + l2:g} mm from the first joint"


# Two parallel revolute joints: the arm of a plane, or a SCARA seen from above.
TWO_LINK_1 = System(
    name="two-link-1",
    coordinates=("x_mm", "y_mm"),
    signs=ELBOWS,
    length_names=("l1", "l2"),
    sizes=(200.0, 150.0),
    table=lambda l1, l2: Chain((DHLink(a_mm=l1), DHLink(a_mm=l2)), joint_names=_THETAS[:2]),
    formulas=_type_1_formulas,
    coordinates_of=lambda _, frame: position_of(frame)[:2],
    singularities=lambda one, joints: elbow_singularities(joints[1], *one.sizes),
    space=_type_1_space,
)

# Type 2 (section 6): two perpendicular revolute joints, the tip on a sphere.


def _type_2_formulas(one: System, goal: Values, side: float) -> Solved:
    (d1, _), (x, y, z) = one.sizes, goal
    out, up = side * sqrt(x * x + y * y), z - d1
    workings = (Quantity("C2 l2", out, "mm"), Quantity("S2 l2", up, "mm"))
    return (atan2(side * y, side * x), atan2(up, out)), workings


def _type_2_space(one: System) -> str:
    d1, l2 = one.sizes
    return f"the surface of a sphere of {l2:g} mm around (0, 0, {d1:g})"


# A vertical revolute joint and a horizontal one: a gun turret, the tip on a sphere.
TWO_LINK_2 = System(
    name="two-link-2",
    coordinates=("x_mm", "y_mm", "z_mm"),
    signs=MappingProxyType({"base front": (1.0,), "base back": (-1.0,)}),
    length_names=("d1", "l2"),
    sizes=(200.0, 150.0),
    table=lambda d1, l2: Chain(
        (DHLink(d_mm=d1, alpha_rad=QUARTER_TURN), DHLink(a_mm=l2)), joint_names=_THETAS[:2]
    ),
    formulas=_type_2_formulas,
    singularities=lambda one, joints: [
        NamedSingularity(
            ON_AXIS,
            to_half_turn(joints[1] - math.pi / 2.0),
            abs(one.sizes[1] * math.cos(joints[1])),
        )
    ],
    space=_type_2_space,
)

# Type 3 (section 7): a turning column that carries a slide.


def _type_3_formulas(_one: System, goal: Values, side: float) -> Solved:
    x, y = goal
    slide = side * sqrt(x * x + y * y)
    return (atan2(side * x, -(side * y)), slide), (Quantity("d2", slide, "mm"),)


def _type_3_space(one: System) -> str:
    low, high = one.chain().limits[1]
    nearest = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
    furthest = max(abs(low), abs(high))
    shape = "disc" if nearest == 0.0 else "ring"
    measures = f"{nearest:g} mm to {furthest:g} mm from the axis"
    return f"a {shape} in the plane z = {one.sizes[0]:g} mm, {measures}"


# A vertical revolute joint that carries a horizontal prismatic one: polar coordinates.
TWO_LINK_3 = System(
    name="two-link-3",
    coordinates=("x_mm", "y_mm"),
    signs=REACHES,
    length_names=("d1",),
    sizes=(200.0,),
    ranges=(ENDLESS, (0.0, 300.0)),
    table=lambda d1: Chain(
        (DHLink(d_mm=d1, alpha_rad=QUARTER_TURN), DHLink(kind=_SLIDE)),
        joint_names=("theta1", "d2"),
    ),
    formulas=_type_3_formulas,
    coordinates_of=lambda _, frame: position_of(frame)[:2],
    singularities=lambda _, joints: [NamedSingularity(ON_AXIS, None, abs(joints[1]))],
    space=_type_3_space,
)

# Types 4 and 5 (section 8): a lift that carries an arm or a slide.


def _type_4_formulas(one: System, goal: Values, side: float) -> Solved:
    (l2,), (x, z) = one.sizes, goal
    rise = side * root(l2 * l2 - x * x)
    workings = (Quantity("l2 C2", x, "mm"), Quantity("l2 S2", rise, "mm"))
    return (z - rise, atan2(rise, x)), workings


def _type_4_singularities(one: System, joints: Values) -> list[NamedSingularity]:
    short = one.sizes[0] * (1.0 - abs(math.cos(joints[1])))
    return [NamedSingularity(LEVEL, to_half_turn(joints[1]), short)]


def _type_4_space(one: System) -> str:
    low, high = one.chain().limits[0]
    circles = f"circles of {one.sizes[0]:g} mm around (0, {low:g}) to (0, {high:g})"
    return f"a strip in the plane y = 0: {circles}"


# A vertical prismatic joint that carries a horizontal revolute one: an arm on a lift.
TWO_LINK_4 = System(
    name="two-link-4",
    coordinates=("x_mm", "z_mm"),
    signs=MappingProxyType({"arm up": (1.0,), "arm down": (-1.0,)}),
    length_names=("l2",),
    sizes=(150.0,),
    ranges=((0.0, 300.0), ENDLESS),
    table=lambda l2: Chain(
        (DHLink(alpha_rad=QUARTER_TURN, kind=_SLIDE), DHLink(a_mm=l2)),
        joint_names=("d1", "theta2"),
    ),
    formulas=_type_4_formulas,
    coordinates_of=lambda _, frame: position_of(frame)[::2],
    singularities=_type_4_singularities,
    space=_type_4_space,
)


def _type_5_space(one: System) -> str:
    (low1, high1), (low2, high2) = one.chain().limits
    across = f"y from {0.0 - high2:g} to {0.0 - low2:g} mm"
    return f"a rectangle in the plane x = 0: {across}, z from {low1:g} to {high1:g} mm"


# Two perpendicular prismatic joints: a plotter on its edge.
TWO_LINK_5 = System(
    name="two-link-5",
    coordinates=("y_mm", "z_mm"),
    signs=ONLY,
    ranges=((0.0, 300.0), (0.0, 300.0)),
    table=lambda: Chain(
        (DHLink(alpha_rad=QUARTER_TURN, kind=_SLIDE), DHLink(kind=_SLIDE)),
        joint_names=("d1", "d2"),
    ),
    formulas=lambda _, goal: ((goal[1], -goal[0]), ()),
    coordinates_of=lambda _, frame: position_of(frame)[1:],
    space=_type_5_space,
)

# Craig's three-link arm: frame 3 stands at the third joint, the tip l3 further.


def _third_joint(one: System, goal: Values) -> tuple[float, float]:
    x, y, phi = goal
    return x - one.sizes[2] * cos(phi), y - one.sizes[2] * sin(phi)


def _three_link_formulas(one: System, goal: Values, side: float) -> Solved:
    l1, l2, _ = one.sizes
    solved = triangle(*_third_joint(one, goal), l1, l2, side)
    third = goal[2] - solved.first - solved.second
    return (solved.first, solved.second, third), solved.workings()


# Three parallel revolute joints; the last link's length is the tool.
THREE_LINK = System(
    name="three-link",
    coordinates=("x_mm", "y_mm", "phi_rad"),
    signs=ELBOWS,
    length_names=("l1", "l2", "l3"),
    sizes=(200.0, 150.0, 80.0),
    table=lambda l1, l2, l3: Chain(
        (DHLink(), DHLink(a_mm=l1), DHLink(a_mm=l2)),
        Convention.CRAIG,
        tool=translation(l3, 0.0, 0.0),
        joint_names=_THETAS,
    ),
    formulas=_three_link_formulas,
    coordinates_of=lambda _, frame: (
        *position_of(frame)[:2],
        atan2(frame[1][0], frame[0][0]),
    ),
    singularities=lambda one, joints: elbow_singularities(joints[1], *one.sizes[:2]),
)
