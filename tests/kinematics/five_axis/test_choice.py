"""The branch nearest a seed, against the best of all branches looked at one by one."""

import math

from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, UNEVEN, goals

from kinematics import FiveAxisArm, JointRange, Joints

FREE = FiveAxisArm(150.0, 120.0, 120.0, 80.0, (JointRange.of(-400, 400),) * 5)
"""Every joint turns more than once, so that each angle has several turns to choose from."""

HALF_TURNS = FiveAxisArm(150.0, 120.0, 120.0, 80.0, (JointRange.of(-180, 180),) * 5)
"""Every range ends where the two turns of one direction meet."""

arms = st.sampled_from((TEACHMOVER, UNEVEN, FREE, HALF_TURNS))
seeds = st.tuples(*[st.floats(-4.0, 4.0)] * 5)


def best_of_all(arm, goal, seed):
    """The least sum of squared changes of any branch within limits, or None."""
    inside = [one.joints for one in arm.branches(goal, seed) if one.within_limits]
    return min((change(joints, seed) for joints in inside), default=None)


def change(joints, seed):
    return sum((a - b) ** 2 for a, b in zip(joints, seed, strict=True))


@given(arms, goals, seeds)
def test_no_branch_within_limits_is_nearer_to_the_seed(arm, goal, angles):
    seed = Joints((arm.limits[0].clamp(angles[0]), *angles[1:]))
    found, least = arm.solve(goal, seed), best_of_all(arm, goal, seed)
    assert (found is None) == (least is None)
    if found is not None and least is not None:
        assert math.isclose(change(found, seed), least, rel_tol=1e-9, abs_tol=1e-9)


@given(arms, st.tuples(*[st.floats(-3.0, 3.0)] * 5))
def test_a_posture_within_limits_is_always_found_from_itself(arm, angles):
    inside = Joints(tuple(b.clamp(a) for b, a in zip(arm.limits, angles, strict=True)))
    pose = arm.fk(inside)
    found = arm.solve(pose, inside)
    assert found is not None
    again = arm.fk(found)
    assert math.dist((pose.x_mm, pose.y_mm, pose.z_mm), (again.x_mm, again.y_mm, again.z_mm)) < 1e-4
