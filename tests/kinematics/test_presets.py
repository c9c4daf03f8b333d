"""The arms that are known by name."""

import math
from dataclasses import replace

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import postures

from kinematics import (
    PRESETS,
    BadNumber,
    Joints,
    KinematicsError,
    Motors,
    MotorSpec,
    SingularTransmission,
    Transmission,
    UnknownPreset,
    preset,
)
from kinematics.transmission import times


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


@every_row(
    "key, near",
    [
        ("TeachMover", "teachmover"),
        ("mini", "minimover5"),  # the first that begins so
    ],
)
def test_a_misspelt_key_is_told_the_nearest(key, near):
    with pytest.raises(UnknownPreset, match=f"did you mean '{near}'") as caught:
        preset(key)
    assert caught.value.nearest == near
    assert isinstance(caught.value, KinematicsError)


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


# Joint angles and gripper opening to motor steps and back.

TEACHMOVER = preset("teachmover")
CABLES = TEACHMOVER.transmission
PLAIN = Transmission(
    tuple(
        MotorSpec(name, 1000.0 + 100 * index, tuple(float(index == j) for j in range(5)), 12.5)
        for index, name in enumerate("abcde")
    )
)
"""Five motors, one a joint, with no motor for the gripper."""
SHIFTED = replace(
    CABLES.with_signs(motors=(1, -1, -1, 1, 1, -1), coordinates=(-1, 1, 1, 1, -1, 1)),
    motors=tuple(
        replace(motor, offset_steps=17.3 * index) for index, motor in enumerate(CABLES.motors)
    ),
)
ALL = (CABLES, PLAIN, SHIFTED, preset("robko01").transmission)

transmissions = st.sampled_from(ALL)
openings = st.floats(0.0, 76.0)
some_postures = postures(TEACHMOVER.arm)


def reference(key):
    arm = preset(key)
    return arm.arm.ik(arm.reference.pose), arm.reference.opening_mm


def test_the_teachmovers_reference_posture_has_the_published_steps():
    joints, opening = reference("teachmover")
    assert CABLES.to_motors(joints, opening) == (0, -508, 1163, 384, 384, 1163)
    exact = CABLES.to_exact(joints, opening)
    assert exact == pytest.approx((0, -507.7, 1163.1, 384.0, 384.0, 1163.1), abs=0.05)


def test_the_mini_movers_reference_posture_has_the_published_steps():
    joints, opening = reference("minimover5")
    motors = preset("minimover5").transmission.to_motors(joints, opening)
    assert motors == (0, -498, 1166, 384, 384, 1166)


@given(transmissions, st.lists(st.integers(-32768, 32767), min_size=6, max_size=6))
def test_steps_to_joints_to_steps_is_exact(transmission, counts):
    motors = Motors(counts[: len(transmission.motors)])
    assert transmission.to_motors(*transmission.to_joints(motors)) == motors


@given(transmissions, some_postures, openings)
def test_rounding_moves_no_motor_by_more_than_half_a_step_of_its_own(transmission, joints, opening):
    motors = transmission.to_motors(joints, opening)
    back = transmission.to_exact(*transmission.to_joints(motors))
    assert back == pytest.approx(motors, abs=1e-6)
    exact = transmission.to_exact(joints, opening)
    for index, motor in enumerate(transmission.motors):
        own = motors[index] - sum(ratio * motors[other] for other, ratio in motor.follows)
        wanted = exact[index] - sum(ratio * exact[other] for other, ratio in motor.follows)
        assert abs(own - wanted) <= 0.5 + 1e-9


@given(some_postures, openings)
def test_a_motor_that_counts_backward_stands_at_the_opposite_steps(joints, opening):
    signs = (1, -1, -1, 1, 1, 1)
    exact = CABLES.to_exact(joints, opening)
    expected = [sign * steps for sign, steps in zip(signs, exact, strict=True)]
    turned = CABLES.with_signs(motors=signs)
    assert turned.to_exact(joints, opening) == pytest.approx(expected)


@given(some_postures, openings, st.floats(-2.6, 0.0))
def test_moving_the_elbow_leaves_the_opening_exactly_as_it_was(joints, opening, elbow):
    before = CABLES.to_motors(joints, opening)
    after = CABLES.to_motors(joints.replace(elbow=elbow), opening)
    assert after[5] - before[5] == after[2] - before[2]
    assert CABLES.to_joints(after)[1] == CABLES.to_joints(before)[1]


def test_motors_see_the_links_angles_to_the_horizontal():
    def change(**angles):
        zero = Joints.of(0, 0, 0, 0, 0)
        return CABLES.to_exact(zero.replace(**angles))

    assert change(shoulder=0.1)[1:] == pytest.approx(
        (
            -7072 / math.tau / 10,
            *(-4158 / math.tau / 10,),
            *(-1536 / math.tau / 10,) * 2,
            -4158 / math.tau / 10,
        )
    )
    level_forearm = change(shoulder=0.1, elbow=-0.1)
    assert level_forearm[2:] == pytest.approx((0, 0, 0, 0), abs=1e-9)
    right, left = change(wrist_roll=0.1)[3:5]
    assert left == pytest.approx(-right)
    assert left > 0


@given(transmissions, some_postures, st.floats(-50, 50))
def test_the_matrix_gives_the_change_of_exact_steps_and_leads_back(
    transmission, rates, opening_rate
):
    zero = transmission.to_exact(Joints((0.0,) * 5), 0.0)
    moved = transmission.to_exact(rates, opening_rate)
    changes = [b - a for a, b in zip(zero, moved, strict=True)]
    made = times(transmission.matrix, (*rates, opening_rate)[: len(transmission.motors)])
    assert made == pytest.approx(changes, abs=1e-6)
    values = (*rates, opening_rate)[: len(made)]
    assert times(transmission.inverse, made) == pytest.approx(values, abs=1e-9)


def test_motors_that_cannot_tell_joints_apart_are_named():
    motors = list(CABLES.motors)
    motors[4] = replace(motors[4], sees=motors[3].sees)
    with pytest.raises(SingularTransmission, match="'left wrist' follow from") as caught:
        Transmission(tuple(motors))
    assert caught.value.motor == "left wrist"
    motors[4] = replace(CABLES.motors[4], steps_per_unit=0.0)
    with pytest.raises(SingularTransmission, match="left wrist"):
        Transmission(tuple(motors))


def test_motors_that_make_no_transmission_are_refused():
    with pytest.raises(KinematicsError, match="not 3"):
        Transmission(CABLES.motors[:3])
    with pytest.raises(KinematicsError, match="'base' must see 5 values, not 6"):
        Transmission(CABLES.motors[:5])
    early = (replace(CABLES.motors[0], follows=((2, 1),)), *CABLES.motors[1:])
    with pytest.raises(KinematicsError, match="only motors listed before it"):
        Transmission(early)
    with pytest.raises(KinematicsError, match="whole ratios"):
        replace(CABLES.motors[5], follows=((2, 0.5),))
    with pytest.raises(BadNumber, match="base steps_per_unit"):
        MotorSpec("base", math.nan, (1.0,))
