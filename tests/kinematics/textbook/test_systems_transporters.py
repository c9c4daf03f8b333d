"""The transporters against their equations, with all solutions, and the five-axis arms."""

import math

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from systems_cases import gap, postures, same_joints

from kinematics import Joints, Pose, preset
from kinematics.five_axis.closed_form import forward_frame
from kinematics.frames.transforms import position_of
from kinematics.textbook.systems import ALPHA_2, REVOLUTE, SYSTEMS, system
from kinematics.textbook.systems.mini_movers import own_angles, relative_angles

angles = st.floats(-math.pi, math.pi)
lengths = st.floats(0.0, 500.0)


@given(angles, lengths, lengths)
def test_equations_2_28_to_2_30_of_the_cylinder(theta, up, r):
    tip = position_of(system("cylindrical").fk((theta, up, r)))
    assert tip == pytest.approx((r * math.cos(theta), r * math.sin(theta), up))


@given(angles, angles, lengths)
def test_equation_2_33_of_the_sphere(phi, theta, r):
    tip = position_of(system("spherical").fk((phi, theta, r)))
    out = r * math.cos(theta)
    expected = (out * math.cos(phi), out * math.sin(phi), r * math.sin(theta))
    assert gap(tip, expected) < 1e-9


@given(angles, angles, angles)
def test_equation_2_35_of_the_revolute_transporter(first, second, third):
    one = REVOLUTE.sized(200.0, 180.0, 140.0)
    lean = math.sin(second) * 180.0 + math.sin(second + third) * 140.0
    up = 200.0 + math.cos(second) * 180.0 + math.cos(second + third) * 140.0
    expected = (math.sin(first) * lean, -math.cos(first) * lean, up)
    assert gap(position_of(one.fk((first, second, third))), expected) < 1e-9


def test_the_sphere_has_four_solutions_and_a_slide_that_cannot_retract_has_two():
    found = system("spherical").ik((100.0, 0.0, 100.0))
    right, reach = math.pi / 4.0, math.hypot(100.0, 100.0)
    expected = {
        "reaching forward": (0.0, right, reach),
        "reaching forward, over the top": (math.pi, math.pi - right, reach),
        "reaching backward": (math.pi, -right, -reach),
        "reaching backward, over the top": (0.0, right - math.pi, -reach),
    }
    assert [branch.name for branch in found] == list(expected)
    for branch in found:
        assert same_joints(system("spherical"), branch.joints, expected[branch.name])
    assert [b.within_limits for b in found] == [True, True, False, False]


def test_the_alpha_ii_stands_straight_on_in_its_home_position():
    drawn = (
        (0.0, 0.0, 1.0, 177.8 + 177.8 + 129.5),
        (0.0, -1.0, 0.0, 0.0),
        (1.0, 0.0, 0.0, 215.0),
        (0.0, 0.0, 0.0, 1.0),
    )
    assert gap(ALPHA_2.fk((0.0, 0.0, 0.0, -math.pi / 2.0, 0.0)), drawn) < 1e-9


FIVE = [one for one in SYSTEMS.values() if one.arm is not None]


@pytest.mark.parametrize("one", FIVE, ids=lambda one: one.name)
@given(data=st.data())
def test_five_axis_systems_are_the_driver_s_arms(one, data):
    joints = data.draw(postures(one))
    relative = Joints(relative_angles(one, joints))
    assert own_angles(one, relative_angles(one, joints)) == pytest.approx(joints)
    assert gap(one.fk(joints), forward_frame(relative.angles_rad, one.arm.lengths)) < 1e-9
    pose = one.arm.fk(relative)
    assert one.arm == preset(one.name.removesuffix("-lecture")).arm
    goal = (pose.x_mm, pose.y_mm, pose.z_mm, pose.pitch_rad, pose.roll_rad)
    ours = one.ik(goal)
    if any(branch.degenerate for branch in ours):
        return  # two names of one posture
    theirs = one.arm.branches(Pose(*goal))
    assert {(b.within_limits, b.name) for b in ours} == {(b.within_limits, b.name) for b in theirs}


@every_row("one", FIVE, ids=lambda one: one.name)
@every_row("base", [0.0, 0.4, -1.0])
@every_row("lean", [0.0, 0.6, -0.6])
@every_row("beside", [0.0, 1e-9, 1e-7])
def test_a_tip_above_the_base_is_met_whatever_way_the_hand_leans(one, base, lean, beside):
    height = one.arm.base_height_mm
    # The hand leans by `lean` out of the vertical; the wrist stands where that puts the tip.
    pose = Pose(0.0, 0.0, height + 300.0, math.pi / 2.0 - lean, 0.3)
    joints = own_angles(
        one, one.arm.branches(pose, Joints((base, 0.0, 0.0, 0.0, 0.0)))[0].joints.angles_rad
    )
    (*first, _), *others = one.fk(joints)
    frame = ((*first, beside), *others)
    found = one.ik(one.goal_of(frame), own_angles(one, (base, 0.0, 0.0, 0.0, 0.0)))
    assert any(gap(one.fk(branch.joints), frame) < 2e-6 for branch in found)
    assert all(branch.free == ("base",) for branch in found)
