"""Guards on the links as capsules, and on sums of joints: what each says and what it leaves out."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import LOOSE, PUMA, TEACHMOVER, VICE, postures

from kinematics import PRESETS, Guards, Joints, KinematicsError, Pose, preset
from kinematics.guards import AngleSum, link_names
from kinematics.guards.shapes import Box

OPEN = Guards(inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None, table=False)
"""No guard at all, so that the one of a test stands alone."""

THICK = replace(OPEN, radii_mm=(35.0, 30.0, 25.0))
BASED = replace(THICK, base_radius_mm=60.0, base_top_mm=150.0)
BOXED = replace(THICK, boxes=(VICE,))
FOREARM = AngleSum(
    "forearm elevation",
    (("shoulder", 1.0), ("elbow", 1.0)),
    math.radians(-100.0),
    math.radians(45.0),
)
DOWN = -math.pi / 2


def broken(guards, joints, arm=LOOSE):
    return {(one.guard, one.quantity): one for one in guards.violations(arm, joints)}


def over(x_mm, z_mm, y_mm=0.0):
    return TEACHMOVER.ik(Pose(x_mm, y_mm, z_mm, DOWN))


def test_a_hand_keeps_its_radius_above_a_box():
    assert broken(BOXED, over(190, 90)) == {}
    assert broken(BOXED, over(190, 85)) == {}
    assert broken(BOXED, over(190, 84.1)) == {}
    found = broken(BOXED, over(190, 80))
    assert set(found) == {("box vice", "hand")}
    one = found["box vice", "hand"]
    assert (one.value_mm, one.bound_mm) == (pytest.approx(-5.0), 0.0)
    assert one.excess_mm == pytest.approx(5.0)
    assert one.sentence == "the hand would be 5.0 mm inside the box 'vice'"


def test_a_box_is_kept_from_the_forearm_and_not_only_from_the_hand():
    shelf = Box("shelf", (180.0, -50.0, 260.0), (220.0, 50.0, 330.0))
    found = broken(replace(THICK, boxes=(shelf,)), Joints.of(0, 60, -60, 0, 0))
    assert set(found) == {("box shelf", "forearm")}


def test_the_tolerance_is_that_of_the_file():
    joints = over(190, 83.0)
    assert broken(replace(BOXED, tolerance_mm=2.1), joints) == {}
    assert broken(replace(BOXED, tolerance_mm=1.9), joints)


def test_a_forearm_folded_onto_the_base_is_refused():
    folded = Joints.of(0, 30, -160, 90, 0)
    found = broken(BASED, folded)
    assert ("base column", "forearm") in found
    sentence = found["base column", "forearm"].sentence
    assert "inside the base column (radius 60 mm, up to z 150 mm)" in sentence
    assert broken(BASED, Joints.of(0, 60, -95, -35, 0)) == {}


def test_an_upper_arm_that_stands_in_the_base_is_left_out_and_one_above_it_is_not():
    low = Joints.of(0, -35, 35, 0, 0)
    assert ("base column", "upper arm") in broken(BASED, low)
    tall = replace(BASED, base_top_mm=180.0)
    assert ("base column", "upper arm") not in broken(tall, low)


def test_the_hand_against_the_upper_arm_is_the_only_pair_of_this_build():
    folded = Joints.of(0, 90, -149, -90, 0)
    found = broken(THICK, folded)
    assert set(found) == {("arm against itself", "hand against the upper arm")}
    one = found["arm against itself", "hand against the upper arm"]
    assert one.sentence.endswith("mm inside the upper arm")
    assert broken(THICK, Joints.of(0, 90, -90, -90, 0)) == {}


def test_links_that_short_ones_separate_always_touch_and_are_left_out():
    arm = replace(LOOSE, forearm_mm=55.0)
    assert broken(THICK, Joints.of(0, 90, -149, -90, 0), arm) == {}


@pytest.mark.parametrize(("elbow_deg", "value_deg"), [(-141.0, -101.0), (6.0, 46.0)])
def test_a_forearm_beyond_its_elevation_is_refused_in_degrees(elbow_deg, value_deg):
    guards = replace(OPEN, sums=(FOREARM,))
    found = guards.violation(LOOSE, Joints.of(0, 40, elbow_deg, 0, 0))
    bound_deg = -100.0 if value_deg < 0 else 45.0
    assert found.guard == "range of the forearm elevation"
    assert math.degrees(found.value_rad) == pytest.approx(value_deg)
    assert math.degrees(found.bound_rad) == pytest.approx(bound_deg)
    assert found.excess_mm == pytest.approx(math.radians(1.0) * 452.1)
    assert f"would be {value_deg:.1f}°, 1.0° beyond its bound of {bound_deg:.1f}°" in found.sentence


def test_a_forearm_within_its_elevation_breaks_nothing_whatever_its_joints_are():
    guards = replace(OPEN, sums=(FOREARM,))
    for shoulder, elbow in ((100, -149), (-35, 60), (45, 0), (0, -100)):
        assert guards.violations(LOOSE, Joints.of(0, shoulder, elbow, 0, 0)) == ()


def test_a_difference_of_joints_may_be_bounded_too():
    apart = AngleSum("fold", (("elbow", 1.0), ("wrist_pitch", -0.5)), -1.0, 1.0)
    guards = replace(OPEN, sums=(apart,))
    assert guards.violations(LOOSE, Joints.of(0, 0, 50, 0, 0)) == ()
    assert guards.violation(LOOSE, Joints.of(0, 0, 50, -40, 0)).quantity == "fold"


@pytest.mark.parametrize("key", PRESETS)
def test_a_preset_knows_nothing_of_its_links_and_surroundings(key):
    guards = preset(key).guards
    assert (guards.radii_mm, guards.boxes, guards.sums) == ((), (), ())
    assert guards.base_radius_mm is None


@given(postures(TEACHMOVER))
def test_the_base_turns_without_bringing_the_arm_nearer_to_itself(joints):
    guards = replace(BASED, table=True)
    turned = joints.replace(base=joints["base"] * 0.5 - 0.3)
    here, there = (guards.violations(LOOSE, one) for one in (joints, turned))
    assert [one.excess_mm for one in here] == pytest.approx([one.excess_mm for one in there])


def test_a_chain_of_six_joints_has_capsules_along_its_links():
    names = link_names(PUMA)
    assert names[-1] == "hand"
    radii = (60.0,) * len(names)
    upright = PUMA.joints_of((0.0, -math.pi / 2, math.pi / 2, 0.0, 0.0, 0.0))
    guards = replace(OPEN, radii_mm=radii, base_radius_mm=90.0, base_top_mm=500.0)
    assert guards.violations(PUMA, upright) == ()
    crate = Box("crate", (-1000.0, -1000.0, 0.0), (1000.0, 1000.0, 2000.0))
    everything = replace(guards, boxes=(crate,)).violations(PUMA, upright)
    assert {one.quantity for one in everything} == set(names)


def test_folding_a_chain_onto_its_base_is_seen():
    radii = (60.0,) * len(PUMA.moving_points)
    guards = replace(OPEN, radii_mm=radii, base_radius_mm=90.0, base_top_mm=500.0)
    found = [
        one.guard
        for shoulder in (60.0, 80.0, 90.0)
        for elbow in (-60.0, -120.0, 120.0, 180.0, 220.0)
        for one in guards.violations(
            PUMA,
            PUMA.joints_of(map(math.radians, (0.0, shoulder, elbow, 0.0, 0.0, 0.0))),
        )
    ]
    assert "base column" in found


def test_radii_must_fit_the_links():
    with pytest.raises(KinematicsError, match="each of upper arm, forearm, hand: 3, not 2"):
        replace(OPEN, radii_mm=(30.0, 20.0)).violations(LOOSE, Joints.of(0, 0, 0, 0, 0))


@given(st.floats(0.0, 79.0), st.floats(0.5, 30.0))
def test_rising_out_of_a_box_makes_it_shallower(z_mm, rise_mm):
    depth, above = (BOXED.depth_mm(LOOSE, over(190, z)) for z in (z_mm, z_mm + rise_mm))
    assert above <= depth + 1e-9
