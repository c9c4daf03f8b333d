"""Arms, strategies and comparisons that the tests of this room share."""

import dataclasses
import math
from itertools import pairwise

from hypothesis import strategies as st
from named_arms import calibrated, table

from kinematics import FiveAxisArm, Guards, JointPath, JointRange, Joints, Pose, preset, system
from kinematics.chains.arm import ChainArm
from kinematics.frames.transforms import translation
from kinematics.guards.shapes import Box

TEACHMOVER = preset("teachmover").arm

UNEVEN = FiveAxisArm(
    100.0,
    200.0,
    120.0,
    60.0,
    tuple(
        JointRange.of(low, high)
        for low, high in ((-170, 185), (-35, 144), (-149, 130), (-100, 90), (-160, 160))
    ),
)
"""Unequal links, an elbow that bends both ways, and a roll range of less than a turn."""

HALF_TURNS = FiveAxisArm(150.0, 120.0, 120.0, 80.0, (JointRange.of(-180, 180),) * 5)
"""Every range ends where the two turns of one direction meet."""

LOOSE = dataclasses.replace(TEACHMOVER, limits=(JointRange.of(-180, 180),) * 5)
"""The same links with nothing in their way: guards are tried where limits would keep it out."""

ARMS = (TEACHMOVER, UNEVEN)

# Arms driven by their link tables, a posture of the Puma, and guards that leave it the table alone.
MINI = ChainArm(system("minimover5").chain())
MEASURED = ChainArm(calibrated(MINI.chain, 1e-4))
"""No closed form of an arm as it was measured is exact, so that it is solved by numbers."""
_ROWS = ((0, 200, 0, 90), (0, 60, 250, 0), (0, 0, 200, 0), (90, 0, 0, 90), (0, 80, 0, 0))
OFF_PLANE = ChainArm(
    table(*((math.radians(t), d, a, math.radians(twist)) for t, d, a, twist in _ROWS)).within(
        [(-2.5, 2.5)] * 5
    )
)
"""Five joints whose hand leaves the plane of base axis and tip by an offset."""
PUMA = ChainArm(dataclasses.replace(system("puma").chain(), base=translation(0.0, 0.0, 660.0)))
START = PUMA.joints_of(map(math.radians, (10.0, -60.0, 110.0, 20.0, 40.0, 10.0)))
TABLE = Guards(inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None)
VICE = Box("vice", (150.0, -60.0, 0.0), (230.0, 60.0, 60.0))
LAMP = Box("lamp", (250.0, -250.0, 250.0), (330.0, -120.0, 700.0))


def postures(arm):
    """Postures within the limits of an arm."""
    angles = (st.floats(bounds.low_rad, bounds.high_rad) for bounds in arm.limits)
    return st.tuples(*angles).map(Joints)


any_arm = st.sampled_from(ARMS)
arm_and_posture = any_arm.flatmap(lambda arm: st.tuples(st.just(arm), postures(arm)))
goals = st.builds(
    Pose,
    st.floats(-700, 700),
    st.floats(-700, 700),
    st.floats(-400, 800),
    st.sampled_from((-math.pi / 2, 0.0, math.pi)) | st.floats(-math.pi, math.pi),
    st.floats(-3.0, 3.0),
)


def distance_mm(a, b):
    return math.dist(a.position_mm, b.position_mm)


def turn_between(a, b):
    return abs(math.remainder(a - b, math.tau))


def same_pose(a, b, mm=1e-6, rad=1e-6):
    return (
        distance_mm(a, b) <= mm
        and turn_between(a.pitch_rad, b.pitch_rad) <= rad
        and turn_between(a.roll_rad, b.roll_rad) <= rad
    )


def deviation_mm(arm, waypoints, goal, samples=16):
    """The largest distance of the tip from the straight line to a goal along joint motions."""
    first = arm.fk(waypoints[0])
    start, end = (one.position_mm for one in (first, goal))
    along = [b - a for a, b in zip(start, end, strict=True)]
    length = sum(part * part for part in along)
    worst = 0.0
    for a, b in pairwise(waypoints):
        for index in range(samples + 1):
            tip = arm.points(JointPath(a, b).at(index / samples))[-1]
            share = sum(d * (p - s) for d, p, s in zip(along, tip, start, strict=True))
            share = min(max(share / length, 0.0), 1.0) if length else 0.0
            foot = [s + share * d for s, d in zip(start, along, strict=True)]
            worst = max(worst, math.dist(tip, foot))
    return worst
