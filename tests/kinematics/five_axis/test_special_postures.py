"""Postures that rounding makes hard: what one holds is met, and what is offered for it holds it."""

import math
import random

import pytest
from amounts import every_row
from kinematics_cases import HALF_TURNS, TEACHMOVER, UNEVEN, same_pose

from kinematics import FiveAxisArm, JointRange, Joints
from kinematics.geometry import AXIS_MM

GOALS = 120

NO_HAND = FiveAxisArm(150.0, 120.0, 90.0, 0.0, (JointRange.of(-180, 180),) * 5)
ARMS = {
    "teachmover": TEACHMOVER,
    "uneven": UNEVEN,
    "equal links, half turns": HALF_TURNS,
    "no hand": NO_HAND,
}


def tiny(chance):
    """Nothing, or anything from rounding to a micron's worth."""
    return chance.choice((0.0, 1.0, -1.0)) * 10.0 ** chance.uniform(-16.0, -5.0)


def anywhere(arm, q, chance):
    return q


def stretched(arm, q, chance):
    return [q[0], q[1], arm.limits[2].clamp(tiny(chance)), *q[3:]]


def folded(arm, q, chance):
    return [q[0], q[1], arm.limits[2].low_rad, *q[3:]]


def vertical(arm, q, chance):
    return [*q[:3], math.pi / 2.0 - q[1] - q[2] + tiny(chance), q[4]]


def over_the_axis(arm, q, chance):
    _, upper, fore, hand = arm.lengths
    r = upper * math.cos(q[1]) + fore * math.cos(q[1] + q[2]) + 1e3 * tiny(chance)
    if abs(r) > hand or hand == 0.0:
        return q
    return [*q[:3], chance.choice((1.0, -1.0)) * math.acos(-r / hand) - q[1] - q[2], q[4]]


def at_a_limit(arm, q, chance):
    joint = chance.randrange(5)
    bounds = arm.limits[joint]
    return [*q[:joint], chance.choice((bounds.low_rad, bounds.high_rad)), *q[joint + 1 :]]


KINDS = (anywhere, stretched, folded, vertical, over_the_axis, at_a_limit)


def postures(arm, kind, chance):
    for _ in range(GOALS):
        q = [chance.uniform(bounds.low_rad, bounds.high_rad) for bounds in arm.limits]
        yield tuple(kind(arm, q, chance))


@every_row("kind", KINDS, ids=lambda kind: kind.__name__)
@every_row("arm", ARMS.values(), ids=ARMS)
def test_what_a_posture_holds_is_met_and_what_is_offered_holds(arm, kind):
    chance = random.Random(7)
    for q in postures(arm, kind, chance):
        pose = arm.fk(Joints(q))
        near = Joints(tuple(bounds.clamp(chance.uniform(-2.0, 2.0)) for bounds in arm.limits))
        solved = arm.solve(pose, near)
        assert solved is not None or arm.violations(Joints(q))
        offered = [branch.joints for branch in arm.branches(pose, near)]
        if math.hypot(pose.x_mm, pose.y_mm) > AXIS_MM:
            offered += [] if solved is None else [solved]
        elif solved is not None:  # a pitch and its mirror image are the same elevation there
            assert math.sin(arm.fk(solved).pitch_rad) == pytest.approx(
                math.sin(pose.pitch_rad), abs=1e-5
            )
        for joints in offered:
            assert same_pose(arm.fk(joints), pose, mm=1e-4, rad=1e-5)
