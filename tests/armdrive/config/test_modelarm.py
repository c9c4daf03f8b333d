"""An arm file that names a model file: what it needs, what it means, and what is wrong in it."""

import math
from dataclasses import replace

import pytest
from chain_files import five_joints, shown_files, six_arm, six_joints, six_links, written

from armdrive.arm import Arm
from armdrive.config.sections import Connection
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmFileError, Refused
from kinematics import Pose, preset
from kinematics.chains.arm import ChainArm


def test_the_shown_files_are_the_teachmover(tmp_path):
    config = five_joints(tmp_path)
    theirs = preset("teachmover")
    assert config.title == "TeachMover by its link table"
    assert config.connection == Connection("teachmover", port="/dev/ttyUSB0")
    arm = config.model.arm
    assert isinstance(arm, ChainArm)
    assert arm.joint_names == theirs.arm.joint_names
    for ours, other in zip(arm.limits, theirs.arm.limits, strict=True):
        assert ours.low_rad == pytest.approx(other.low_rad)
        assert ours.high_rad == pytest.approx(other.high_rad)
    assert config.model.reference == theirs.reference
    assert config.model.gripper_range_mm == theirs.gripper_range_mm
    assert config.model.grip_steps_per_n == pytest.approx(theirs.grip_steps_per_n, rel=1e-3)
    for ours, other in zip(
        config.model.transmission.motors, theirs.transmission.motors, strict=True
    ):
        assert ours.steps_per_unit == pytest.approx(other.steps_per_unit)
        assert (ours.name, ours.sees, ours.follows) == (other.name, other.sees, other.follows)


def test_a_reference_and_a_park_posture_of_six_joints_have_a_yaw(tmp_path):
    posture = "x_mm = 450\ny_mm = 100\nz_mm = 500\npitch_deg = -90\nyaw_deg = 15\n"
    config = six_joints(tmp_path, f"[reference]\n{posture}[park]\n{posture}")
    wanted = Pose.of(x_mm=450, y_mm=100, z_mm=500, pitch_deg=-90, yaw_deg=15)
    assert config.model.reference.pose == wanted
    assert config.park == wanted


def test_six_joints_home_and_park_with_the_simulated_operator(tmp_path):
    posture = "x_mm = 500\ny_mm = 100\nz_mm = 400\npitch_deg = -80\nyaw_deg = 15\n"
    config = six_joints(tmp_path, f"[reference]\n{posture}")
    with Arm(
        connect_simulated(replace(config, motion=replace(config.motion, planned_burst_s=2.0)))
    ) as arm:
        assert isinstance(arm, Arm)
        arm.home()
        arm.move_j(waist_deg=30)
        arm.park()
        assert math.dist(arm.twin.world.tip, (500, 100, 430)) < 1.0


def test_what_gives_steps_their_meaning_changes_the_fingerprint(tmp_path):
    first = six_joints(tmp_path)
    assert first.calibration == six_joints(tmp_path).calibration
    assert first.calibration == six_joints(tmp_path, "[limits_deg]\nbend = [-90, 90]\n").calibration
    (tmp_path / "six.toml").write_text(six_links(base_height=661.0), encoding="utf-8")
    assert written(tmp_path, six_arm()).calibration != first.calibration


def test_limits_of_the_arm_file_take_the_models_place(tmp_path):
    config = six_joints(tmp_path, "[limits_deg]\nbend = [-50, 60]\n")
    assert config.model.arm.limits[4].high_rad == pytest.approx(math.radians(60))


def test_guards_may_be_asked_for(tmp_path):
    guards = six_joints(tmp_path, "[guards]\nouter_radius_mm = 700\n").model.guards
    assert (guards.outer_radius_mm, guards.inner_radius_mm) == (700, None)


FIRST = '[[motors]]\nname = "waist"\nsteps_per_turn = 14400\nsees = { waist = 1 }\n'
SECOND = "sees = { shoulder = 1 }\n"


IN_ARM = [
    ("model", "lengths = {}\nmodel", "unknown key 'lengths'"),
    ('"six.toml"', '"five.toml"', "five.toml cannot be read"),
    ("waist = 30\n", "", r"speeds_deg_s\] is missing waist"),
    ("waist = 30\n", "waist = 0\n", "speeds_deg_s.waist must be from"),
    ("waist = 30\n", "base = 30\n", "unknown key 'base'"),
    (FIRST, "", "5 motors|needs 6|need 6"),
    (FIRST, FIRST.replace("{ waist = 1 }", "{ wast = 1 }"), "did you mean 'waist'"),
    (FIRST, FIRST.replace("sees = { waist = 1 }\n", ""), "sees no joint"),
    (FIRST, FIRST.replace("14400", "-14400"), "directions are signs in sees"),
    (FIRST, FIRST.replace("steps_per_turn", "steps_per_mm"), "must be the last"),
    (FIRST, FIRST.replace("steps_per_turn = 14400\n", ""), "needs steps_per_turn"),
    (FIRST, FIRST.replace('name = "waist"\n', ""), "needs a name"),
    (FIRST, FIRST.replace('"waist"', '"bend"'), "different names"),
    (FIRST, FIRST + "follows = { bend = 1 }\n", "unknown key 'bend'"),
    (SECOND, SECOND + "follows = { waist = 0.5 }\n", "whole number"),
    (FIRST, FIRST.replace("waist = 1 }", "shoulder = 1 }"), "tells nothing"),
    (FIRST, "[fingers]\nrange_mm = [0, 1]\nspeed_mm_s = 1\n" + FIRST, "no motor has steps_per"),
    (FIRST, "[park]\nx_mm = 1\n" + FIRST, "is missing y_mm"),
    (FIRST, "[guards]\ntable = 0\n" + FIRST, "unknown key 'table'"),
]
IN_MODEL = [
    ("low_deg = -160\n", "", "waist' has no limits"),
    ('joint = "waist"', 'joint = "my waist"', "cannot be called 'my waist'"),
    ('joint = "waist"', 'joint = "opening"', "cannot be called 'opening'"),
    ('joint = "waist"\n', 'joint = "waist"\nkind = "prismatic"\n', "prismatic joint has no"),
]
IN_FINGERS = [
    ("[fingers]\nrange_mm = [0, 76]\nspeed_mm_s = 20\nsteps_per_n", "[park]\n#", "fingers"),
    ("range_mm = [0, 76]", "range_mm = [76, 0]", "below the second"),
    ("speed_mm_s = 20", "speed_mm_s = 0", "fingers.speed_mm_s must be"),
]
FILES = {"six": (six_links(), six_arm()), "five": shown_files()}


@pytest.mark.parametrize(
    ("files", "old", "new", "said"),
    [("six", *row) for row in (*IN_ARM, *IN_MODEL)] + [("five", *row) for row in IN_FINGERS],
)
def test_what_is_wrong_in_either_file_is_named(tmp_path, files, old, new, said):
    links, arm = FILES[files]
    assert (old in links) != (old in arm), "a row changes one of the two files"
    for name in ("six.toml", "minilinks.toml"):
        (tmp_path / name).write_text(links.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ArmFileError, match=said):
        written(tmp_path, arm.replace(old, new, 1))


def test_every_motor_of_the_controller_must_be_listed(tmp_path):
    links, arm = shown_files()
    (tmp_path / "minilinks.toml").write_text(links, encoding="utf-8")
    gripper = arm[arm.index('[[motors]]\nname = "gripper"') : arm.index("[speeds_deg_s]")]
    config = written(tmp_path, arm.replace(gripper, ""))
    assert not config.model.transmission.has_gripper
    with pytest.raises(Refused, match="5 motors, but its controller drives 6"):
        connect_simulated(config)


def test_a_servo_gripper_has_fingers_without_a_motor(tmp_path):
    fingers = "[fingers]\nrange_mm = [5, 60]\nspeed_mm_s = 40\n"
    config = six_joints(tmp_path, '[gripper]\nkind = "servo"\n' + fingers)
    assert config.model.gripper_range_mm == (5.0, 60.0)
    assert not config.model.transmission.has_gripper


def test_an_unverified_model_is_marked(tmp_path):
    (tmp_path / "six.toml").write_text("verified = false\n" + six_links(), encoding="utf-8")
    assert not written(tmp_path, six_arm()).model.verified
