"""Jacobians against small moves, joint rates with damping, singular values without numpy."""

import math

import numpy as np
import pytest
from chain_cases import MINI_MOVER, PUMA, chains_and_values, columns_by_differences, gap
from hypothesis import assume, given
from hypothesis import strategies as st
from kinematics_cases import arm_and_posture

from kinematics import KinematicsError
from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.jacobians import (
    THRESHOLD,
    dimensionless,
    geometric_jacobian,
    joint_rates,
)
from kinematics.chains.links import DHLink, JointKind
from kinematics.five_axis.rates import task_jacobian
from kinematics.frames.matrices import singular, transposed


@given(chains_and_values(most=6))
def test_the_geometric_jacobian_is_what_small_moves_do(case):
    chain, values = case
    columns = transposed(geometric_jacobian(chain, values))
    assert gap(columns, columns_by_differences(chain, values)) < 1e-4


@given(chains_and_values())
def test_the_generated_jacobian_is_the_geometric_one(case):
    chain, values = case
    made = generated(chain).jacobian(values)
    assert gap(made, geometric_jacobian(chain, values)) < 1e-8


def wrapped(angle):
    return math.remainder(angle, math.tau)


@given(arm_and_posture)
def test_the_task_jacobian_is_the_derivative_of_the_pose(case):
    arm, joints = case
    pose = arm.fk(joints)
    assume(math.hypot(pose.x_mm, pose.y_mm) > 1.0)
    columns = []
    for name in joints.names:
        ends = [arm.fk(joints.replace(**{name: joints[name] + step})) for step in (1e-5, -1e-5)]
        columns.append(
            [(getattr(ends[0], f"{axis}_mm") - getattr(ends[1], f"{axis}_mm")) / 2e-5
             for axis in "xyz"]
            + [wrapped(getattr(ends[0], f"{turn}_rad") - getattr(ends[1], f"{turn}_rad")) / 2e-5
               for turn in ("pitch", "roll")]
        )  # fmt: skip
    assert gap(transposed(task_jacobian(arm, joints)), columns) < 1e-4


matrices = st.tuples(st.integers(1, 6), st.integers(1, 6)).flatmap(
    lambda size: st.lists(
        st.lists(
            st.sampled_from([0.0, 1.0, -2.0, 1e-7, 300.0]), min_size=size[1], max_size=size[1]
        ).map(tuple),
        min_size=size[0],
        max_size=size[0],
    ).map(tuple)
)


@given(matrices)
def test_singular_values_are_those_of_numpy(matrix):
    parts = singular(matrix)
    expected = np.linalg.svd(np.array(matrix), compute_uv=False)
    assert parts.values == pytest.approx(tuple(expected), rel=1e-9, abs=1e-9)


@given(matrices)
def test_the_singular_parts_make_up_the_matrix(matrix):
    parts = singular(matrix)
    rebuilt = sum(
        value * np.outer(left, right)
        for value, left, right in zip(parts.values, parts.left, parts.right, strict=True)
    )
    assert np.abs(rebuilt - np.array(matrix)).max() < 1e-9


def test_small_singular_values_keep_their_digits():
    matrix = tuple(tuple(1.0 / (row + column + 1) for column in range(6)) for row in range(6))
    assert singular(matrix).values[-1] == pytest.approx(1.082799484566e-07, rel=1e-9)  # Hilbert


def test_mm_are_counted_in_a_length():
    rows = ((200.0, 1.0), (0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    kinds = (JointKind.REVOLUTE, JointKind.PRISMATIC)
    assert dimensionless(rows, 100.0, kinds)[0] == (2.0, 1.0)
    assert dimensionless(rows, 100.0, kinds)[3] == (1.0, 0.0)
    assert dimensionless(rows, 100.0)[0] == (2.0, 0.01)


rates_of_six = st.tuples(*[st.floats(-200.0, 200.0)] * 3, *[st.floats(-2.0, 2.0)] * 3)
postures_of_six = st.tuples(*[st.floats(-3.0, 3.0)] * 6)


@given(postures_of_six, rates_of_six)
def test_rates_are_exact_away_from_singularities_and_bounded_at_them(values, wanted):
    length = PUMA.longest_reach_mm
    found = joint_rates(generated(PUMA).jacobian(values), wanted, length_mm=length)
    size = math.hypot(*(rate / length for rate in wanted[:3]), *wanted[3:])
    assert math.hypot(*found.joints) <= size / THRESHOLD + 1e-9
    assert found.damped == (found.smallest < THRESHOLD)
    if not found.damped:
        assert max(map(abs, found.missed)) < 1e-9 * max(1.0, size) * length
    total = [a + m for a, m in zip(found.achieved, found.missed, strict=True)]
    assert total == pytest.approx(wanted, abs=1e-9)


def test_a_straight_elbow_damps_only_the_direction_that_is_lost():
    two_link = generated(Chain((DHLink(a_mm=200.0), DHLink(a_mm=100.0))))
    stretched = two_link.jacobian((0.0, 0.0))[:2]
    along_and_across = joint_rates(stretched, (30.0, 60.0), length_mm=300.0)
    assert along_and_across.damped
    assert along_and_across.achieved == pytest.approx((0.0, 60.0), abs=1e-9)
    assert along_and_across.missed == pytest.approx((30.0, 0.0), abs=1e-9)


@given(postures_of_six, rates_of_six, st.floats(1e-6, 1e-4))
def test_damping_sets_in_continuously(values, wanted, step):
    jacobian = generated(PUMA).jacobian(values)
    smallest = joint_rates(jacobian, wanted, length_mm=1000.0).smallest
    assume(smallest > 1e-3)
    below, above = (
        joint_rates(jacobian, wanted, length_mm=1000.0, threshold=smallest * (1.0 + sign * step))
        for sign in (1, -1)
    )
    assert below.damped
    assert not above.damped
    change = math.dist(below.joints, above.joints)
    assert change <= 3.0 * step * math.hypot(*above.joints) + 1e-12


def test_five_axes_miss_what_they_have_no_axis_for():
    jacobian = generated(MINI_MOVER).jacobian((0.0, 0.6, -1.0, 0.2, 0.0))
    found = joint_rates(jacobian, (0, 0, 0, 1.0, 0, 0.0), length_mm=450.0)
    assert math.hypot(*found.missed) > 0.01
    assert not found.damped or found.smallest < THRESHOLD


@pytest.mark.parametrize(
    ("rates", "options", "message"),
    [
        ((1.0,), {}, "6 tip rates are needed, not 1"),
        ((0.0,) * 6, {"length_mm": 0.0}, "length_mm must be more than 0"),
        ((0.0,) * 6, {"threshold": -1.0}, "threshold must be more than 0"),
        ((math.nan,) * 6, {}, "a tip rate must be a finite number"),
    ],
)
def test_rates_that_make_no_sense_are_refused(rates, options, message):
    jacobian = generated(PUMA).jacobian((0.1,) * 6)
    with pytest.raises(KinematicsError, match=message):
        joint_rates(jacobian, rates, **{"length_mm": 900.0, **options})
