"""Arms of the Mini-mover's build in the textbook's terms: the Mini-mover 5 and the Alpha II.

The hand's frame has z along the hand (approach) and, with the roll at zero, x upwards in the arm's
plane (normal). Checked answers come from `FiveAxisArm`, the formulas run on numbers of any kind.
Sources: McKerrow, chapter 4, section 16 (the Mini-mover 5 and its elbow triangle); T. Asokan,
Introduction to Robotics, lecture 2.7 (the Alpha II). Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

from kinematics.chains.chain import Chain
from kinematics.chains.goals import HandTask, pose_of
from kinematics.chains.links import DHLink
from kinematics.errors import KinematicsError
from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.closed_form import plane_tip
from kinematics.frames.numbers import atan2, cos, sin, sqrt
from kinematics.frames.transforms import Transform
from kinematics.frames.vectors import ZERO
from kinematics.geometry import AXIS_MM
from kinematics.presets import preset
from kinematics.spaces import JOINT_NAMES, Jacobian
from kinematics.textbook.systems.named import (
    QUARTER_TURN,
    NamedSingularity,
    Quantity,
    Solved,
    System,
    Values,
)
from kinematics.textbook.systems.triangle import elbow_singularities, triangle

COORDINATES = ("x_mm", "y_mm", "z_mm", "pitch_rad", "roll_rad")
SIGNS = MappingProxyType(
    {
        "base front, elbow up": (1.0, -1.0),
        "base front, elbow down": (1.0, 1.0),
        "base back, elbow up": (-1.0, 1.0),
        "base back, elbow down": (-1.0, -1.0),
    }
)


def arm_of(one: System) -> FiveAxisArm:
    """Return the arm of a system of this build; raises `KinematicsError` for any other."""
    if one.arm is None:
        raise KinematicsError(f"{one.name} is no arm of the Mini-mover's build")
    return one.arm


def with_arm(one: System, arm: FiveAxisArm) -> System:
    """Return a system of this build with another arm's lengths and limits."""
    lows = own_angles(one, tuple(limits.low_rad for limits in arm.limits))
    highs = own_angles(one, tuple(limits.high_rad for limits in arm.limits))
    ranges = tuple((min(pair), max(pair)) for pair in zip(lows, highs, strict=True))
    return replace(one, arm=arm, sizes=arm.lengths, ranges=ranges)


def own_angles(one: System, angles: Values) -> Values:
    """Return relative angles, up positive, as the system's own joint values."""
    return tuple(_turned(angle, *sense) for angle, sense in zip(angles, one.senses, strict=True))


# Back again: where a joint has an offset it is mirrored too, so that turning twice is nothing.
relative_angles = own_angles


def _turned(angle: float, sign: float, offset: float) -> float:
    """Return an angle by the other count; what stays as it is costs a formula no operation."""
    turned = -angle if sign < 0.0 else angle
    return turned + offset if offset else turned


# The determinant of the task Jacobian is r * a2 * a3 * sin(elbow), up to its sign, where r is the
# tip's distance from the base axis: the build is singular with the elbow straight or folded, and
# with the tip over the base, and nowhere else.


def own_angle_rows(one: System, joints: Values) -> Jacobian:
    """Return the rows pitch and roll (rad/rad) of the Jacobian, by the system's own joints.

    A tip behind the base axis pitches against its joints (see `five_axis`); on the axis itself
    pitch counts as in front.
    """
    r, _ = _tip(one, joints)
    sense = -1.0 if r < -AXIS_MM else 1.0
    signs = [sign for sign, _ in one.senses]
    return (0.0, *(sense * sign for sign in signs[1:4]), 0.0), (0.0, 0.0, 0.0, 0.0, signs[4])


def _tip(one: System, joints: Values) -> tuple[float, float]:
    """Return how far out in the arm's plane the tip is, and how far above the shoulder."""
    lengths = arm_of(one).lengths
    _, shoulder, elbow, wrist, _ = relative_angles(one, joints)
    r, z, _ = plane_tip(shoulder, elbow, wrist, lengths)
    return r, z - lengths[0]


def _formulas(one: System, goal: Values, side: float, bend: float) -> Solved:
    (height, upper, fore, hand), (x, y, z, pitch, roll) = one.sizes, goal
    base = atan2(side * y, side * x)
    cp, sp = side * cos(pitch), sin(pitch)
    r0 = side * sqrt(x * x + y * y) - hand * cp
    z0 = z - height - hand * sp
    elbow = triangle(r0, z0, upper, fore, bend)
    wrist = atan2(sp, cp) - elbow.first - elbow.second
    turned = roll + (1.0 - side) / 2.0 * math.pi
    joints = own_angles(one, (base, elbow.first, elbow.second, wrist, turned))
    return joints, (Quantity("r0", r0, "mm"), Quantity("z0", z0, "mm"), *elbow.workings())


def _coordinates_of(_one: System, frame: Transform) -> Values:
    """Return x, y, z, pitch and roll of a hand; on the base axis in the hand's own plane."""
    pose = pose_of(frame, HandTask.IN_PLANE, ZERO)
    return *pose.position_mm, pose.pitch_rad, pose.roll_rad


ELBOW_FOLDED = (
    "the elbow is folded: the wrist cannot move nearer to the shoulder, and elbow up and "
    "elbow down are the same posture"
)
ELBOW_STRAIGHT = (
    "the elbow is straight: the wrist cannot move further from the shoulder, and elbow up and "
    "elbow down are the same posture"
)
TIP_OVER_BASE = (
    "the tip is on the base axis: turning the base only turns the hand, and the tip cannot "
    "move across the plane that the arm stands in"
)


def _singularities(one: System, joints: Values) -> Sequence[NamedSingularity]:
    """Return the three ways in which this build is singular (see `own_angle_rows`).

    The shoulder alone can bring the tip over the base, since its axis meets the base axis.
    """
    _, _, elbow, _, _ = relative_angles(one, joints)
    _, upper, fore, _ = arm_of(one).lengths
    straight, folded = elbow_singularities(elbow, upper, fore)
    r, rise = _tip(one, joints)
    by_shoulder = math.atan2(abs(r), abs(rise)) if r or rise else 0.0
    return [
        replace(folded, reason=ELBOW_FOLDED),
        replace(straight, reason=ELBOW_STRAIGHT),
        NamedSingularity(TIP_OVER_BASE, by_shoulder, abs(r)),
    ]


def _alpha2_table(height: float, upper: float, fore: float, hand: float) -> Chain:
    links = (
        DHLink(d_mm=height, alpha_rad=-QUARTER_TURN),
        DHLink(a_mm=upper),
        DHLink(a_mm=fore),
        DHLink(alpha_rad=-QUARTER_TURN),
        DHLink(d_mm=hand),
    )
    return Chain(links, joint_names=("base", "shoulder", "elbow", "tool_pitch", "tool_roll"))


def _minimover_table(height: float, upper: float, fore: float, hand: float) -> Chain:
    links = (
        DHLink(d_mm=height, alpha_rad=QUARTER_TURN),
        DHLink(a_mm=upper),
        DHLink(a_mm=fore),
        DHLink(alpha_rad=QUARTER_TURN, offset=QUARTER_TURN),
        DHLink(d_mm=hand),
    )
    return Chain(links, joint_names=JOINT_NAMES)


# The Mini-mover 5, or any arm of its build, in relative angles with up positive.
#
# Its link table is in this project's own joint angles: base; shoulder, the elevation of the upper
# arm; elbow, forearm less upper arm; wrist pitch, hand less forearm; wrist roll.
MINI_MOVER = with_arm(
    System(
        name="minimover5",
        coordinates=COORDINATES,
        signs=SIGNS,
        length_names=("d1", "a2", "a3", "d5"),
        table=_minimover_table,
        formulas=_formulas,
        coordinates_of=_coordinates_of,
        singularities=_singularities,
        senses=((1.0, 0.0),) * 5,
    ),
    preset("minimover5").arm,
)

# The Alpha II, or any arm of its build, in the angles of the lecture's link table.
#
# Axes 2, 3 and 4 point the other way than those of the Mini-mover, so that angles count downwards,
# and theta4 is -90 degrees with the hand straight on.
ALPHA_2 = with_arm(
    replace(
        MINI_MOVER,
        name="alpha2-lecture",
        table=_alpha2_table,
        senses=((1.0, 0.0), (-1.0, 0.0), (-1.0, 0.0), (-1.0, -QUARTER_TURN), (1.0, 0.0)),
    ),
    preset("alpha2").arm,
)
