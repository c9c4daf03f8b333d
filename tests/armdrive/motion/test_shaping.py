"""Points mirrored, offset and turned: laws on the presets and on arms of model files."""

import math
from dataclasses import replace
from functools import partial

import pytest
from amounts import every_row
from chain_files import six_arm, six_links
from hypothesis import assume, given
from hypothesis import strategies as st

from armdrive.connect.target import find
from armdrive.errors import OutOfBounds, Refused
from armdrive.motion.shape import Offset, derived, mirrored, offset
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import load_arm
from armdrive.storage.points import Point
from kinematics import Joints

TEACHMOVER = find("sim:teachmover").config
POSTURES = st.tuples(
    st.floats(-60, 60),
    st.floats(10, 60),
    st.floats(-90, -20),
    st.floats(-60, 0),
    st.floats(-80, 80),
).map(lambda angles: Joints.of(*angles))


def near(a, b, tolerance=1e-6):
    return all(math.dist(p, q) < tolerance for p, q in zip(a, b, strict=True))


@given(POSTURES)
def test_mirrored_twice_is_where_it_was_and_once_is_the_reflection(joints):
    arm = TEACHMOVER.model.arm
    other = mirrored(TEACHMOVER, joints)
    assert near(arm.points(other), [(x, -y, z) for x, y, z in arm.points(joints)])
    assert other["base"] == pytest.approx(-joints["base"])
    assert other["wrist_roll"] == pytest.approx(-joints["wrist_roll"])
    assert tuple(mirrored(TEACHMOVER, other)) == pytest.approx(tuple(joints), abs=1e-9)


@every_row("name", DIALECTS)
def test_every_preset_is_mirrored_by_its_base_and_its_roll(name):
    config = find(f"sim:{name}").config
    angles = [20.0, 40.0, -60.0, -30.0, 15.0]
    names = config.model.arm.joint_names
    joints = Joints.of(*angles, names=names)
    other = mirrored(config, joints)
    assert list(other.deg.values()) == pytest.approx([-20.0, 40.0, -60.0, -30.0, -15.0])


def test_an_arm_that_is_not_the_same_on_both_sides_brings_its_hand_to_the_mirrored_pose(tmp_path):
    (tmp_path / "six.toml").write_text(six_links(), encoding="utf-8")
    path = tmp_path / "arm.toml"
    path.write_text(six_arm(), encoding="utf-8")
    config = load_arm(path)
    arm = config.model.arm
    joints = Joints.of(20.0, -30.0, 60.0, 10.0, 40.0, 5.0, names=arm.joint_names)
    pose, other = arm.fk(joints), arm.fk(mirrored(config, joints))
    assert (other.x_mm, other.y_mm, other.z_mm) == pytest.approx(
        (pose.x_mm, -pose.y_mm, pose.z_mm), abs=1e-3
    )
    turned = [other.pitch_rad - pose.pitch_rad, other.roll_rad + pose.roll_rad]
    turned.append(other.yaw_rad + pose.yaw_rad)
    assert all(abs(math.remainder(angle, math.tau)) < 1e-5 for angle in turned)


@given(POSTURES, st.floats(-15, 15), st.floats(-15, 15), st.floats(-15, 15))
def test_an_offset_shifts_the_tip_and_keeps_pitch_and_roll(joints, x_mm, y_mm, z_mm):
    arm = TEACHMOVER.model.arm
    pose = arm.fk(joints)
    goal = replace(pose, x_mm=pose.x_mm + x_mm, y_mm=pose.y_mm + y_mm, z_mm=pose.z_mm + z_mm)
    assume(arm.solve(goal, joints) is not None)
    there = arm.fk(offset(TEACHMOVER, joints, Offset(x_mm, y_mm, z_mm)))
    assert (there.x_mm, there.y_mm, there.z_mm) == pytest.approx(
        (pose.x_mm + x_mm, pose.y_mm + y_mm, pose.z_mm + z_mm), abs=1e-6
    )
    assert there.pitch_rad == pytest.approx(pose.pitch_rad, abs=1e-9)
    assert there.roll_rad == pytest.approx(pose.roll_rad, abs=1e-9)


@given(POSTURES, st.floats(-20, 20))
def test_a_turn_turns_the_base_alone(joints, turn_deg):
    turned = offset(TEACHMOVER, joints, Offset(turn_rad=math.radians(turn_deg)))
    assert turned.deg["base"] == pytest.approx(joints.deg["base"] + turn_deg)
    assert tuple(turned)[1:] == tuple(joints)[1:]


@pytest.mark.parametrize(
    ("by", "error", "why"),
    [
        (Offset(turn_rad=1.0), OutOfBounds, "the base"),
        (Offset(x_mm=900.0), Refused, ""),
        (Offset(z_mm=-110.0), Refused, "mm below the table"),
    ],
    ids=["beyond a limit", "out of reach", "within a guard"],
)
def test_a_point_that_cannot_go_there_is_refused_by_its_name(by, error, why):
    point = Point(Joints.of(80.0, 40.0, -80.0, -40.0, 0.0))
    with pytest.raises(error, match=f"the point 'pick' cannot go there: .*{why}") as caught:
        derived(TEACHMOVER, "pick", point, partial(offset, TEACHMOVER, by=by))
    assert error is Refused or caught.value.name == "base"


def test_a_new_point_keeps_the_opening_and_its_note_says_where_it_comes_from():
    point = Point(Joints.of(20.0, 40.0, -80.0, -40.0, 10.0), 40.0, "safe")
    made = derived(TEACHMOVER, "pick", point, partial(mirrored, TEACHMOVER), "pick mirrored")
    assert made.joints.deg["base"] == pytest.approx(-20.0)
    assert (made.opening_mm, made.note) == (40.0, "safe; pick mirrored")
