"""Rates of the five-axis build: of its joints for a moving tip, and of the tip for moving joints.

Lengths in mm, angles in rad. The tip's rates are x, y, z, pitch and roll; the joints' follow from
solving the build's own two links and its turning base (the derivative of the five-axis closed form:
McKerrow, chapter 4, sections 12 and 16). Nothing but floats and tuples is made, and nothing is
checked: a jog asks many times a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import cos, sin

from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.closed_form import Angles, Lengths
from kinematics.geometry import AXIS_MM
from kinematics.spaces import Jacobian, Joints

SMALLEST_SINE = 1e-9
"""A sine of the elbow so small counts as none: the elbow is straight or folded."""


def joint_rates(angles: Angles, tip: Sequence[float], lengths: Lengths) -> Angles | None:
    """Return the joints' rates for the tip's rates, None where the posture is singular."""
    base, shoulder, elbow, wrist, _ = angles
    vx, vy, vz, pitching, rolling = tip
    _, upper, fore, hand = lengths
    second = shoulder + elbow
    third = second + wrist
    cos_first, cos_second, cos_third = cos(shoulder), cos(second), cos(third)
    sin_first, sin_second, sin_third = sin(shoulder), sin(second), sin(third)
    r = upper * cos_first + fore * cos_second + hand * cos_third
    bend = sin(elbow)
    cos_base, sin_base = cos(base), sin(base)
    across = vy * cos_base - vx * sin_base
    if -SMALLEST_SINE < bend < SMALLEST_SINE or (-AXIS_MM < r < AXIS_MM and across):
        return None
    if r < 0.0:
        pitching = -pitching
    out = vx * cos_base + vy * sin_base + hand * sin_third * pitching
    up = vz - hand * cos_third * pitching
    first = (out * cos_second + up * sin_second) / (upper * bend)
    both = -(out * cos_first + up * sin_first) / (fore * bend)
    return (across / r if across else 0.0, first, both - first, pitching - both, rolling)


# The task Jacobian of the five-axis build.
#
# Its determinant in the build's own task space (x, y, z, pitch, roll) is r * a2 * a3 * sin(elbow),
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
