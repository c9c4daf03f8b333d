"""The task Jacobian of the five-axis build: the rates of the tip for moving joints.

Lengths in mm, angles in rad. The tip's rates are x, y, z, pitch and roll.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.closed_form import Lengths
from kinematics.geometry import AXIS_MM
from kinematics.spaces import Jacobian, Joints

# The determinant in the build's own task space (x, y, z, pitch, roll) is r * a2 * a3 * sin(elbow),
# up to its sign, where r is the tip's distance from the base axis: the build is singular with the
# elbow straight or folded, and with the tip over the base, and nowhere else.


def task_jacobian(arm: FiveAxisArm, joints: Joints) -> Jacobian:
    """Return the five rows x, y, z (mm/rad), pitch and roll (rad/rad) of the five-axis build.

    The derivative of `FiveAxisArm.fk`. A tip behind the base axis pitches against its joints
    (see `arm`); on the axis itself pitch counts as in front, and the tip can leave in the
    arm's own plane only.
    """
    arm.fk(joints)  # checks that these are the build's joints
    base, *plane, _ = joints.angles_rad
    to_tip = from_joints_to_tip(plane, arm.lengths)
    r = to_tip[0][0]
    cos_base, sin_base = math.cos(base), math.sin(base)
    sense = -1.0 if r < -AXIS_MM else 1.0
    return (
        (-r * sin_base, *(-cos_base * rise for _, rise in to_tip), 0.0),
        (r * cos_base, *(-sin_base * rise for _, rise in to_tip), 0.0),
        (0.0, *(reach for reach, _ in to_tip), 0.0),
        (0.0, sense, sense, sense, 0.0),
        (0.0, 0.0, 0.0, 0.0, 1.0),
    )


def from_joints_to_tip(plane: Sequence[float], lengths: Lengths) -> list[tuple[float, float]]:
    """Return how far the tip lies outwards of and above shoulder, elbow and wrist.

    `plane` holds their angles. What is above a joint is also how fast the tip moves inwards while
    that joint turns.
    """
    shoulder, elbow, wrist = plane
    _, upper, fore, hand = lengths
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
