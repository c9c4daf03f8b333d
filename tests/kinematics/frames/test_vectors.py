"""Vectors: products, lengths, angles, and what a vector without a direction cannot tell."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from frame_cases import directed, vectors
from hypothesis import given
from hypothesis import strategies as st

from kinematics import ZeroVector
from kinematics.chains.assignment import AxisLine
from kinematics.frames.vectors import (
    X_AXIS,
    ZERO,
    add,
    angle_between,
    any_normal,
    cross,
    dot,
    norm,
    project,
    reject,
    scale,
    unit,
)

factors = st.floats(-20.0, 20.0)


@given(vectors, vectors, vectors, factors, factors)
def test_the_scalar_product_is_linear_and_commutes(u, v, w, a, b):
    together = dot(add(scale(a, u), scale(b, v)), w)
    apart = a * dot(u, w) + b * dot(v, w)
    assert math.isclose(together, apart, rel_tol=1e-9, abs_tol=1e-4)
    assert dot(u, v) == dot(v, u)


@given(directed, directed)
def test_the_vector_product_is_normal_to_both_and_as_long_as_they_span(u, v):
    w = cross(u, v)
    size = norm(u) * norm(v)
    assert abs(dot(w, u)) <= 1e-9 * size * norm(u)
    assert abs(dot(w, v)) <= 1e-9 * size * norm(v)
    assert math.isclose(norm(w), size * math.sin(angle_between(u, v)), abs_tol=1e-9 * size)
    assert gap(w, scale(-1.0, cross(v, u))) == 0.0


@every_row("tiny", [1e-12, 1e-9, 1e-6])
def test_the_smallest_angles_keep_their_digits(tiny):
    u, v = X_AXIS, (math.cos(tiny), math.sin(tiny), 0.0)
    assert math.isclose(angle_between(u, v), tiny, rel_tol=1e-9)
    assert math.isclose(math.pi - angle_between(scale(-1.0, u), v), tiny, abs_tol=1e-15)


@given(directed, directed)
def test_a_vector_is_its_part_along_and_its_part_across(u, v):
    along, across = project(u, v), reject(u, v)
    assert gap(add(along, across), u) < 1e-9 * norm(u)
    assert abs(dot(across, v)) < 1e-9 * norm(u) * norm(v)
    assert norm(cross(along, v)) < 1e-9 * norm(u) * norm(v)


@given(directed)
def test_some_unit_vector_is_normal_to_any_vector(u):
    v = any_normal(u)
    assert math.isclose(norm(v), 1.0)
    assert abs(dot(u, v)) <= 1e-12 * norm(u)


@every_row(
    "ask",
    [
        unit,
        any_normal,
        lambda zero: angle_between(zero, X_AXIS),
        lambda zero: angle_between(X_AXIS, zero),
        lambda zero: project(X_AXIS, zero),
        lambda zero: AxisLine(ZERO, zero),
    ],
)
def test_no_direction_is_made_up(ask):
    with pytest.raises(ZeroVector, match="no direction"):
        ask(ZERO)
