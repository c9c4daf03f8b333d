"""Arms driven by their link tables: the five-axis arm's answers, and laws of six joints."""

import dataclasses
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from kinematics_cases import (
    MINI,
    PUMA,
    START,
    TABLE,
    same_pose,
)
from named_arms import calibrated

from kinematics import (
    Joints,
    Pose,
    Unreachable,
    first_violation,
    nearest_allowed,
    preset,
)
from kinematics.chains.arm import ChainArm

FIVE = preset("minimover5").arm
MEASURED = ChainArm(calibrated(MINI.chain, 1e-4))
"""No closed form of an arm as it was measured is exact, so that a small step is a descent."""
EITHER = pytest.mark.parametrize("arm", [MINI, MEASURED], ids=["closed form", "descent"])


def moved(pose, step):
    x, y, z = step
    return dataclasses.replace(pose, x_mm=pose.x_mm + x, y_mm=pose.y_mm + y, z_mm=pose.z_mm + z)


def postures(arm, margin=0.02):
    return st.tuples(
        *(st.floats(one.low_rad + margin, one.high_rad - margin) for one in arm.limits)
    ).map(arm.joints_of)


@given(postures(MINI))
def test_a_mini_mover_by_its_link_table_is_the_five_axis_arm(joints):
    ours, theirs = MINI.fk(joints), FIVE.fk(joints)
    if math.hypot(theirs.x_mm, theirs.y_mm) > 0.1:
        assert same_pose(ours, theirs, mm=1e-9, rad=1e-9)
        assert ours.yaw_rad is None
    for a, b in zip(MINI.points(joints), FIVE.points(joints), strict=True):
        assert math.dist(a, b) < 1e-9
    # about the shoulder the table counts the distance from its axis, as the fast arm does
    for a, b in zip(MINI.levers_mm(joints), FIVE.levers_mm(joints), strict=True):
        assert math.isclose(a, b, abs_tol=1e-5)
    assert MINI.travel_bound_mm((1, 2, 3, 4, 5)) == pytest.approx(
        FIVE.travel_bound_mm((1, 2, 3, 4, 5))
    )
    for a, b in zip(TABLE.violations(MINI, joints), TABLE.violations(FIVE, joints), strict=True):
        assert math.isclose(a.value, b.value, abs_tol=1e-9)


def test_the_table_is_kept_by_every_point_and_left_upwards():
    low = Pose.of(x_mm=500, y_mm=0, z_mm=-60, pitch_deg=-60, yaw_deg=0)
    joints = PUMA.ik(low, START)
    broken = TABLE.violations(PUMA, joints)
    assert "tip z" in [one.quantity for one in broken]
    allowed = nearest_allowed(PUMA, TABLE, low, START)
    assert allowed is not None
    assert allowed.z_mm == pytest.approx(0.0, abs=0.01)
    found = first_violation(PUMA, TABLE, [START, joints])
    assert found is not None
    assert 0.0 < found[0] <= 1.0


# The quick solver for jogs: it holds the pose, stays near and within the limits.


@EITHER
def test_beyond_the_reach_or_a_limit_there_is_nothing(arm):
    straight = Joints((0.0, 0.3, 0.0, 0.0, 0.0))
    turned = Joints((math.pi / 2, 0.7, -1.4, -0.7, 0.0))
    assert arm.solve_near(moved(arm.fk(straight), (20.0, 0.0, 5.0)), straight) is None
    assert arm.solve_near(moved(arm.fk(turned), (-5.0, 0.0, 0.0)), turned) is None
    assert FIVE.solve_near(moved(FIVE.fk(straight), (20.0, 0.0, 5.0)), straight) is None


@EITHER
@given(
    shoulder=st.just(0.3),
    turns=st.tuples(*[st.floats(-0.02, 0.02)] * 5),
    bend=st.floats(0.003, 0.03),
)
@example(shoulder=MINI.limits[1].low_rad, turns=(0.0, 0.01, 0.0, 0.0, 0.0), bend=0.02)
def test_a_straight_elbow_at_its_limit_can_be_left(arm, shoulder, turns, bend):
    straight = (-0.2, shoulder, arm.limits[2].high_rad, -0.6, -0.6)
    base, up, _, *wrist = (a + b for a, b in zip(straight, turns, strict=True))
    goal = arm.fk(arm.joints_of((base, up, straight[2] - bend, *wrist)))
    found = arm.solve_near(goal, arm.joints_of(straight))
    assert same_pose(arm.fk(found), goal, mm=1e-4, rad=1e-5)
    assert not arm.violations(found)


def test_a_small_step_never_turns_the_wrist_over():
    nearly_straight = PUMA.joints_of((0.3, -0.8, 1.1, 0.4, 0.03, -0.5))
    goal = moved(PUMA.fk(nearly_straight), (-20.0, 20.0, 0.0))
    with pytest.raises(Unreachable, match="because the posture is singular here"):
        PUMA.ik_near(goal, nearly_straight)
