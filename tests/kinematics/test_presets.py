"""The arms that are known by name."""

import dataclasses
import math

import pytest
from amounts import every_row

from kinematics import PRESETS, Joints, KinematicsError, UnknownPreset, preset
from kinematics.frames.matrices import times


@every_row(
    "key, lengths",
    [
        ("minimover5", (195.0, 177.8, 177.8, 96.5)),
        ("teachmover", (193.7, 177.8, 177.8, 96.5)),
        ("alpha2", (215.0, 177.8, 177.8, 129.5)),
        ("robko01", (190.0, 178.0, 178.0, 92.0)),
    ],
)
def test_every_arm_has_its_published_lengths(key, lengths):
    assert preset(key).arm.lengths == lengths
    assert preset(key).key == key


def test_the_table_holds_exactly_these_arms_and_cannot_be_changed():
    assert list(PRESETS) == [
        "minimover5", "teachmover", "alpha2", "robko01", "armdroid1", "minimover5-mks",
        "minimover5-cia402",
    ]  # fmt: skip
    with pytest.raises(TypeError):
        PRESETS["mine"] = preset("teachmover")
    with pytest.raises(dataclasses.FrozenInstanceError):
        preset("teachmover").verified = False


@every_row(
    "key, near",
    [
        ("TeachMover", "teachmover"),
        ("teach-mover", "teachmover"),
        ("mini", "minimover5"),  # the first that begins so
        ("ARMDROID", "armdroid1"),
    ],
)
def test_a_misspelt_key_is_told_the_nearest(key, near):
    with pytest.raises(UnknownPreset, match=f"did you mean '{near}'") as caught:
        preset(key)
    assert caught.value.nearest == near
    assert isinstance(caught.value, KinematicsError)


def test_an_arm_on_closed_loop_drives_counts_its_encoders_and_is_a_template():
    arm, minimover = preset("minimover5-mks"), preset("minimover5")
    assert not arm.verified
    assert "template" in arm.notes
    turn = Joints.of(360, 0, 0, 0, 0)
    assert arm.transmission.to_motors(turn)[0] == 50 * 0x4000
    rad_s = minimover.joint_speeds_rad_s
    rpm = [60 * rate / 0x4000 for rate in times(arm.transmission.matrix, (*rad_s, 20.0))]
    assert max(map(abs, rpm)) < 600
    # a newton is as many mm of the cable as on the arm whose mechanics it has
    per_n = [each.grip_steps_per_n / each.transmission.motors[-1].steps_per_unit
             for each in (arm, minimover)]  # fmt: skip
    assert per_n[0] == pytest.approx(per_n[1])


@every_row("key", PRESETS)
def test_every_reference_posture_is_in_reach_and_outside_the_guards(key):
    arm = preset(key)
    if arm.reference is None:
        assert "reference posture" in arm.notes
        return
    joints = arm.arm.ik(arm.reference.pose)
    assert arm.guards.violations(arm.arm, joints) == ()
    motors = arm.transmission.to_motors(joints, arm.reference.opening_mm)
    rounded, opening = arm.transmission.to_joints(motors)
    assert arm.guards.violations(arm.arm, rounded) == ()
    assert opening == pytest.approx(arm.reference.opening_mm, abs=0.05)


def test_robkos_steps_are_those_of_its_software_and_its_elbow_counts_backward():
    robko = preset("robko01").transmission
    zero = Joints.of(0, 0, 0, 0, 0)
    one = 1.0
    assert robko.to_exact(zero.replace(base=one))[0] == pytest.approx(1222.7)
    assert robko.to_exact(zero.replace(shoulder=-one))[1] == pytest.approx(1161.4)
    assert robko.to_exact(zero.replace(elbow=one))[2] == pytest.approx(680.1)
    assert robko.to_exact(zero.replace(wrist_pitch=-one))[3:5] == pytest.approx((244.7, 244.7))
    assert robko.to_exact(zero, 10.0)[5] == pytest.approx(270.0)
    still = robko.to_joints(robko.to_motors(zero.replace(elbow=-1.0), 30.0))[1]
    assert still == pytest.approx(30.0, abs=0.02)


def test_the_teachmovers_speeds_are_its_papers():
    arm = preset("teachmover")
    assert arm.joint_speeds_rad_s == (0.37, 0.15, 0.23, 1.31, 1.31)
    assert arm.gripper_range_mm == (0.0, 76.0)
    base_half_steps_s = times(arm.transmission.matrix, (0.42, 0, 0, 0, 0, 0))[0]
    assert base_half_steps_s == pytest.approx(0.42 * 7072 / math.tau)
