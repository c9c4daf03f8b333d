"""The nearest pose outside guards on links, boxes, and sums of joints."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import LAMP, PUMA, START, TABLE, TEACHMOVER, VICE, distance_mm, same_pose

from kinematics import Guards, Joints, Pose, nearest_allowed
from kinematics.guards import AngleSum
from kinematics.guards.shapes import Box

BOXED = Guards(radii_mm=(35.0, 30.0, 25.0), boxes=(VICE, LAMP))
BASED = replace(BOXED, boxes=(), base_radius_mm=60.0, base_top_mm=150.0)
LEVEL = AngleSum(
    "forearm elevation", (("shoulder", 1.0), ("elbow", 1.0)), math.radians(-95), math.radians(20)
)
SUMMED = Guards(sums=(LEVEL,))
AWAY = Joints.of(60, 60, -95, -35, 0)


def allowed(guards, pose, seed=None, arm=TEACHMOVER):
    joints = arm.solve(pose, seed)
    return joints is not None and not guards.violations(arm, joints)


@pytest.mark.parametrize(
    ("goal", "nearest"),
    [
        ((190, 0, 70), (190, 0, 85)),
        ((190, 70, 20), (190, 85, 20)),
        ((240, 0, 20), (255, 0, 20)),
    ],
)
def test_a_hand_in_a_box_comes_out_by_the_nearest_side(goal, nearest):
    found = nearest_allowed(TEACHMOVER, BOXED, Pose(*map(float, goal), -math.pi / 2))
    assert found.position_mm == pytest.approx(nearest, abs=1e-6)
    assert found.pitch_rad == -math.pi / 2


def test_a_hand_in_the_base_comes_out_of_it():
    goal = Pose.of(x_mm=100, y_mm=20, z_mm=60, pitch_deg=-90)
    thick = replace(BASED, base_radius_mm=90.0, base_top_mm=100.0)
    assert thick.violation(TEACHMOVER, TEACHMOVER.ik(goal)).guard == "base column"
    found = nearest_allowed(TEACHMOVER, thick, goal)
    assert allowed(thick, found)
    assert math.hypot(found.x_mm, found.y_mm) == pytest.approx(115.0, abs=1.0)
    assert math.atan2(found.y_mm, found.x_mm) == pytest.approx(math.atan2(20, 100), abs=1e-3)
    assert (found.z_mm, found.pitch_rad) == pytest.approx((60.0, goal.pitch_rad), abs=1.0)


def test_a_forearm_too_low_is_brought_back_into_its_range():
    goal = Pose.of(x_mm=127, y_mm=0, z_mm=0, pitch_deg=-90)
    broken = SUMMED.violation(TEACHMOVER, TEACHMOVER.ik(goal))
    assert broken.quantity == "forearm elevation"
    found = nearest_allowed(TEACHMOVER, SUMMED, goal)
    assert allowed(SUMMED, found)
    assert found.pitch_rad == goal.pitch_rad
    assert distance_mm(found, goal) < 40.0


@given(
    st.floats(100, 330),
    st.floats(-1.2, 1.2),
    st.floats(-20, 300),
    st.sampled_from((-1.57, -1.2, -0.6)),
    st.sampled_from((BOXED, BASED, SUMMED)),
)
def test_with_an_allowed_seed_there_is_always_an_answer_and_it_is_allowed(
    r, base, z, pitch, guards
):
    goal = Pose(r * math.cos(base), r * math.sin(base), z, pitch)
    assert not guards.violations(TEACHMOVER, AWAY)
    found = nearest_allowed(TEACHMOVER, guards, goal, AWAY)
    assert allowed(guards, found, AWAY)
    if allowed(guards, goal, AWAY):
        assert same_pose(found, goal, mm=1e-4)


def test_where_nothing_near_is_free_the_way_from_the_seed_gives_the_answer():
    slabs = [Box(f"slab {z}", (-400.0, -400.0, z), (400.0, 150.0, z + 1.0)) for z in (0.0, 90.0)]
    stacked = Guards(
        radii_mm=(0.0, 0.0, 0.0),
        boxes=(*slabs, Box("block", (60.0, -400.0, -400.0), (600.0, 100.0, 500.0))),
    )
    goal = Pose.of(x_mm=250, y_mm=-100, z_mm=50, pitch_deg=-80)
    assert not stacked.violations(TEACHMOVER, AWAY)
    found = nearest_allowed(TEACHMOVER, stacked, goal, AWAY)
    assert allowed(stacked, found, AWAY)


def test_an_arm_of_six_joints_comes_out_of_a_box_too():
    radii = (60.0,) * len(PUMA.moving_points)
    pose = PUMA.fk(START)
    x, y, z = pose.position_mm
    crate = Box("crate", (x - 50, y - 50, z - 200), (x + 50, y + 50, z - 30))
    guards = replace(TABLE, radii_mm=radii, boxes=(crate,))
    assert guards.violation(PUMA, START).guard == "box crate"
    found = nearest_allowed(PUMA, guards, pose, START)
    assert allowed(guards, found, START, PUMA)
    assert distance_mm(found, pose) < 150.0


def test_a_stretched_arm_finds_a_way_out_although_half_of_its_probes_are_out_of_reach():
    stretched = Joints.of(0, 30, 0, -30, 0)  # the forearm is at 30 degrees, where 20 are allowed
    pose = TEACHMOVER.fk(stretched)
    guards = replace(SUMMED, outer_radius_mm=None)
    assert not allowed(guards, pose)
    assert allowed(guards, nearest_allowed(TEACHMOVER, guards, pose, AWAY), AWAY)
