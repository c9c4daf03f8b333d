"""Jacobians: what unit rates of the joints make the tip do, and how well it can move.

Geometric, of any chain: each column is the joint's axis z and z x (tip - axis) (Whitney, 1972;
Craig, chapter 5). In the task space of the five-axis build: x, y, z, pitch, roll. Lengths in mm,
angles in rad, rates per second of whatever the joint is measured in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from kinematics.chains import Chain
from kinematics.closed_form import AXIS_MM, plane_tip
from kinematics.five_axis import FiveAxisArm, RollFrame
from kinematics.frames import position_of
from kinematics.generated import Jacobian
from kinematics.linear import singular
from kinematics.links import JointKind
from kinematics.spaces import Joints
from kinematics.vectors import cross, subtract

POSITION_ROWS = (0, 1, 2)
"""The rows of a geometric Jacobian that concern the tip's position."""

ALL_ROWS = (0, 1, 2, 3, 4, 5)


def geometric_jacobian(chain: Chain, values: Sequence[float]) -> Jacobian:
    """Return the geometric Jacobian: rows v along x, y, z, then turning about x, y, z.

    On any kind of number; `generated(chain).jacobian` is the same on floats, many times as fast.
    Raises as `Chain.fk` does.
    """
    tip = position_of(chain.fk(values))
    columns = []
    for kind, (point, axis) in zip(chain.kinds, chain.axes(values), strict=True):
        if kind is JointKind.REVOLUTE:
            columns.append((*cross(axis, subtract(tip, point)), *axis))
        else:
            columns.append((*axis, 0.0, 0.0, 0.0))
    return tuple(zip(*columns, strict=True))


def task_jacobian(
    arm: FiveAxisArm, joints: Joints, roll_frame: RollFrame = RollFrame.HAND
) -> Jacobian:
    """Return the five rows x, y, z (mm/rad), pitch and roll (rad/rad) of the five-axis build.

    The derivative of `FiveAxisArm.fk`. A tip behind the base axis pitches against its joints
    (see five_axis.py); on the axis itself pitch counts as in front, and the tip can leave in the
    arm's own plane only.
    """
    arm.fk(joints)  # checks that these are the build's joints
    base, shoulder, elbow, wrist, _ = joints.angles_rad
    r, _, _ = plane_tip(shoulder, elbow, wrist, arm.lengths)
    joints_above = _above(arm, shoulder, elbow, wrist)
    cos_base, sin_base = math.cos(base), math.sin(base)
    outwards = [-rise for _, rise in joints_above]
    upwards = [reach for reach, _ in joints_above]
    sense = -1.0 if r < -AXIS_MM else 1.0
    turns_roll = -1.0 if roll_frame is RollFrame.TABLE else 0.0
    return (
        (-r * sin_base, *(cos_base * rate for rate in outwards), 0.0),
        (r * cos_base, *(sin_base * rate for rate in outwards), 0.0),
        (0.0, *upwards, 0.0),
        (0.0, sense, sense, sense, 0.0),
        (turns_roll, 0.0, 0.0, 0.0, 1.0),
    )


def _above(
    arm: FiveAxisArm, shoulder: float, elbow: float, wrist: float
) -> list[tuple[float, float]]:
    """Return how far the tip lies outwards of and above shoulder, elbow and wrist, in the plane."""
    _, upper, fore, hand = arm.lengths
    found = []
    reach = rise = 0.0
    for length, elevation in (
        (hand, shoulder + elbow + wrist),
        (fore, shoulder + elbow),
        (upper, shoulder),
    ):
        reach += length * math.cos(elevation)
        rise += length * math.sin(elevation)
        found.append((reach, rise))
    return found[::-1]


def dimensionless(
    jacobian: Jacobian,
    length_mm: float,
    kinds: Sequence[JointKind] = (),
    position_rows: Sequence[int] = POSITION_ROWS,
) -> Jacobian:
    """Return a Jacobian whose mm are counted in a length, so that its entries compare.

    Rows of the position are divided by it, columns of slides (`kinds`, none by default)
    multiplied. Without it, singular values mix mm with rad and mean nothing.
    """
    columns = [
        length_mm if kind is JointKind.PRISMATIC else 1.0
        for kind in (kinds or [JointKind.REVOLUTE] * len(jacobian[0]))
    ]
    return tuple(
        tuple(
            entry * column / (length_mm if index in position_rows else 1.0)
            for entry, column in zip(row, columns, strict=True)
        )
        for index, row in enumerate(jacobian)
    )


def manipulability(jacobian: Jacobian) -> float:
    """Return the volume of what unit joint rates make the tip do (Yoshikawa, 1985).

    The product of the singular values: |det J| of a square Jacobian, zero where the arm is
    singular. Its unit follows the rows'.
    """
    return math.prod(singular(jacobian).values)
