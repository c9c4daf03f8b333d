"""Poses in front of an arm, and measures of paths in joint space, that tests of routes share."""

import math
from itertools import pairwise

from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER

from kinematics import Joints, KinematicsError, Pose, line_path
from kinematics.paths.chords import TINY_RAD


def pose(x_mm, y_mm, z_mm, pitch_deg=-90.0, roll_deg=0.0):
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=pitch_deg, roll_deg=roll_deg)


START = TEACHMOVER.ik(pose(250, -100, 120))

poses = st.builds(
    lambda r, angle, z, pitch, roll: Pose(r * math.cos(angle), r * math.sin(angle), z, pitch, roll),
    st.floats(150, 330),
    st.floats(-1.2, 1.2),
    st.floats(30, 250),
    st.floats(-1.5, -0.2),
    st.floats(-1.5, 1.5),
)


def at(start, goal, share):
    """The posture at a share of a joint motion."""
    angles = (a + share * (b - a) for a, b in zip(start, goal, strict=True))
    return Joints(tuple(angles), start.names)


def tip(arm, joints):
    return arm.points(joints)[-1]


def point(pose):
    return pose.position_mm


def directions(corners):
    return [tuple(b - a for a, b in zip(one, two, strict=True)) for one, two in pairwise(corners)]


def turn_deg(one, two):
    """The angle between two directions in joint space."""
    a, b = (tuple(part / math.hypot(*way) for part in way) for way in (one, two))
    return math.degrees(
        2 * math.atan2(math.dist(a, b), math.hypot(*(x + y for x, y in zip(a, b, strict=True))))
    )


def sharpest_deg(corners):
    """The sharpest corner between chords that are not both tiny."""
    ways = directions(corners)
    return max(
        (
            turn_deg(one, two)
            for one, two in pairwise(ways)
            if max(math.hypot(*one), math.hypot(*two)) > TINY_RAD
        ),
        default=0.0,
    )


def reached(arm, start, goals):
    """The postures of straight lines from goal to goal, or None where one cannot be followed."""
    found = [start]
    for goal in goals:
        try:
            found.append(line_path(arm, found[-1], goal)[-1])
        except KinematicsError:
            return None
    return found
