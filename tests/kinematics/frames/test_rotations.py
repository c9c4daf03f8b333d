"""Rotation matrices: the group they form, and the check that a matrix belongs to it."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from frame_cases import any_angle, rotations
from hypothesis import given
from hypothesis import strategies as st

from kinematics import (
    BadNumber,
    KinematicsError,
    NotARotation,
    check_rotation,
)
from kinematics.frames.rotations import (
    IDENTITY,
    determinant,
    multiply,
    rot_x,
    rot_y,
    rotation_between,
    transpose,
)


@given(any_angle, any_angle)
def test_turns_about_two_axes_are_the_products_of_the_notes(first, second):
    c1, s1, c2, s2 = math.cos(first), math.sin(first), math.cos(second), math.sin(second)
    x_then_y = ((c2, 0.0, s2), (s1 * s2, c1, -s1 * c2), (-c1 * s2, s1, c1 * c2))  # (2.25)
    y_then_x = ((c2, s1 * s2, c1 * s2), (0.0, c1, -s1), (-s2, s1 * c2, c1 * c2))  # (2.26)
    assert gap(multiply(rot_x(first), rot_y(second)), x_then_y) < 1e-15
    assert gap(multiply(rot_y(second), rot_x(first)), y_then_x) < 1e-15


@given(rotations, rotations, rotations)
def test_rotations_are_a_group(a, b, c):
    product = multiply(a, b)
    assert gap(multiply(product, transpose(product)), IDENTITY) < 1e-14
    assert math.isclose(determinant(multiply(a, b)), 1.0, abs_tol=1e-12)
    assert gap(multiply(a, transpose(a)), IDENTITY) < 1e-14
    assert gap(multiply(multiply(a, b), c), multiply(a, multiply(b, c))) < 1e-14
    assert gap(transpose(multiply(a, b)), multiply(transpose(b), transpose(a))) < 1e-15
    assert multiply() == IDENTITY
    assert multiply(a) == a


@given(st.lists(rotations, max_size=5), st.data())
def test_any_frame_of_a_chain_is_seen_from_any_other(steps, data):
    ends = st.integers(0, len(steps))
    i, j, k = data.draw(ends), data.draw(ends), data.draw(ends)
    through = multiply(rotation_between(steps, i, k), rotation_between(steps, k, j))
    assert gap(through, rotation_between(steps, i, j)) < 1e-13
    assert rotation_between(steps, i, i) == IDENTITY
    for at, step in enumerate(steps):
        assert rotation_between(steps, at, at + 1) == step


@every_row(
    "matrix, said",
    [
        (((2, 0, 0), (0, 1, 0), (0, 0, 1)), ["column x has length 2 instead of 1"]),
        (((1, 0, 0), (0, 1, 0), (0, 0, 0)), ["column z has length 0 instead of 1"]),
        (
            ((1, math.sin(0.1), 0), (0, math.cos(0.1), 0), (0, 0, 1)),
            ["columns x and y stand at 84.270422° instead of 90°"],
        ),
        (
            ((1, 0, 0), (0, 1, 0), (0, 0, -1)),
            ["the determinant is -1 instead of 1: the axes are left-handed"],
        ),
        (
            ((0.0, 1.1, 0.0), (1.0, 0.1, 0.0), (0.0, 0.0, 1.0)),
            [
                "column y has length 1.1045361 instead of 1",
                "columns x and y stand at 84.8055711° instead of 90°",
                "the determinant is -1.1 instead of 1: the axes are left-handed",
            ],
        ),
    ],
)
def test_the_check_says_what_is_wrong_and_by_how_much(matrix, said):
    with pytest.raises(NotARotation) as refused:
        check_rotation(matrix)
    assert list(refused.value.flaws) == said
    assert all(flaw in str(refused.value) for flaw in refused.value.flaws)


@every_row(
    "matrix, error, says",
    [
        (((1, 0, 0), (0, math.nan, 0), (0, 0, 1)), BadNumber, "row 2, y"),
        (((1, 0, 0), (0, 1, 0), (math.inf, 0, 1)), BadNumber, "row 3, x"),
        (((1, 0, 0), (0, "1", 0), (0, 0, 1)), BadNumber, "'1'"),
        (((1, 0), (0, 1)), KinematicsError, "3 rows of 3"),
        (((1, 0, 0), (0, 1, 0), (0, 1)), KinematicsError, "3 rows of 3"),
    ],
)
def test_what_is_no_matrix_of_numbers_is_refused(matrix, error, says):
    with pytest.raises(error, match=says):
        check_rotation(matrix)
