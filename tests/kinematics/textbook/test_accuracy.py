"""What steps, roundings and wrong parameters do to the tip."""

import math

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, distance_mm, postures

from kinematics import Joints, preset
from kinematics.textbook.accuracy import (
    gearing_errors,
    length_errors,
    rounding_bound_mm,
    rounding_rms_mm,
    step_errors,
)
from kinematics.textbook.efficiency import (
    Ledger,
    Tally,
    efficiency,
)
from kinematics.textbook.systems import SYSTEMS

MODEL = preset("teachmover")
STEPS = MODEL.transmission
REACHING = Joints.of(20, 50, -70, -10, 30)


def by_cause(errors):
    return {error.cause: error for error in errors}


@given(postures(TEACHMOVER))
def test_one_step_turns_one_link_and_carries_the_rest_along(joints):
    found = by_cause(step_errors(TEACHMOVER, STEPS, joints))
    tip = TEACHMOVER.fk(joints)
    out = math.hypot(tip.x_mm, tip.y_mm)
    assert found["base"].distance_mm == pytest.approx(out * math.tau / 7072, rel=1e-6, abs=1e-9)
    assert found["shoulder"].distance_mm == pytest.approx(177.8 * math.tau / 7072, rel=1e-6)
    assert found["elbow"].distance_mm == pytest.approx(177.8 * math.tau / 4158, rel=1e-6)
    for wrist in ("right wrist", "left wrist"):
        assert found[wrist].distance_mm == pytest.approx(96.5 * math.pi / 1536, rel=1e-6)
        assert abs(found[wrist].roll_rad) == pytest.approx(math.pi / 1536)
    assert found["shoulder"].pitch_rad == pytest.approx(0.0, abs=1e-12)
    assert "gripper" not in found


@given(postures(TEACHMOVER))
def test_rounding_to_whole_steps_stays_within_the_bound(joints):
    rounded, _ = STEPS.to_joints(STEPS.to_motors(joints))
    missed = distance_mm(TEACHMOVER.fk(rounded), TEACHMOVER.fk(joints))
    bound = rounding_bound_mm(TEACHMOVER, STEPS, joints)
    assert missed <= bound * 1.01
    assert 0.05 < rounding_rms_mm(TEACHMOVER, STEPS, joints) < bound < 0.8


def test_a_length_s_error_moves_the_tip_along_its_link():
    found = by_cause(length_errors(TEACHMOVER, REACHING, 0.5))
    for error in found.values():
        assert error.distance_mm == pytest.approx(0.5)
        assert (error.pitch_rad, error.roll_rad) == (0.0, 0.0)
    assert found["base_height_mm"].offset_mm == pytest.approx((0.0, 0.0, 0.5))
    out = math.cos(math.radians(50)) * 0.5
    assert math.hypot(*found["upper_arm_mm"].offset_mm[:2]) == pytest.approx(out)


def test_a_wrong_gearing_shows_the_more_the_farther_from_the_reference():
    at_reference = gearing_errors(TEACHMOVER, STEPS, REACHING, 0.02, REACHING)
    assert all(error.distance_mm < 1e-9 for error in at_reference)
    near, far = (
        by_cause(gearing_errors(TEACHMOVER, STEPS, Joints.of(turn, 40, -60, 0, 0), 0.02))["base"]
        for turn in (10, 40)
    )
    assert far.distance_mm == pytest.approx(4 * near.distance_mm, rel=0.01)
    tip = TEACHMOVER.fk(Joints.of(10, 40, -60, 0, 0))
    missed = math.radians(10) * (1 - 1 / 1.02)
    out = math.hypot(tip.x_mm, tip.y_mm)
    assert near.distance_mm == pytest.approx(out * missed, rel=1e-4)


# Counting numbers count what runs, and the counts say which way of computing is worth it.

FREE_OF_ARITHMETIC = {"cartesian", "two-link-5"}
"""Their joints are their coordinates."""

floats = st.floats(-100.0, 100.0)


def by_name(ways):
    return {way.name: way.tally for way in ways}


@given(floats, floats)
def test_counting_numbers_compute_what_floats_do(a, b):
    ledger = Ledger()
    x, y = ledger.numbers((a, b))
    found = (2.0 * x + y * y - 1.0, 3.0 - x, -y, abs(x), y.atan2(x), x.atan2_of(b), x.sin())
    assert list(map(float, found)) == [
        2.0 * a + b * b - 1.0,
        3.0 - a,
        -b,
        abs(a),
        math.atan2(b, a),
        math.atan2(b, a),
        math.sin(a),
    ]
    assert ledger.tally() == Tally(multiplications=2, additions=3, sines=1, arcs=2)
    assert (x < y, x <= b, x == a, bool(x)) == (a < b, a <= b, True, bool(a))


def test_the_minimover_s_counts():
    forward = by_name(efficiency(SYSTEMS["minimover5"]).forward)
    assert forward["own products"] == Tally(53, 27, sines=10)
    assert forward["affine products"] == Tally(174, 108, sines=10)
    assert forward["full products"] == Tally(286, 192, sines=10)


@every_row("name", sorted(SYSTEMS))
def test_every_system_s_ways_are_counted(name):
    found = efficiency(SYSTEMS[name])
    forward = by_name(found.forward)
    own, full = forward["own products"], forward["full products"]
    links = len(SYSTEMS[name].chain())
    assert full == Tally(6 * links + 64 * (links - 1), 48 * (links - 1), sines=full.sines)
    assert own.multiplications < full.multiplications
    branches = set(SYSTEMS[name].signs)
    counted = {way.name for way in found.inverse}
    assert counted == (set() if name in FREE_OF_ARITHMETIC else branches)
