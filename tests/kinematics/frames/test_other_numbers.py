"""The formulas of vectors, rotations and frames run on numbers that are not floats.

Here on dual numbers, a value with its slope: what comes out must be the derivative.
"""

from __future__ import annotations

import pytest
from frame_cases import any_angle
from hypothesis import given
from kinematics_cases import Dual

from kinematics.frames.orientations import RPY, AxisAngle, EulerZYZ
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import (
    compose,
    invert,
    position_of,
    transform,
    transform_point,
    translation,
)
from kinematics.frames.vectors import X_AXIS, angle_between, norm


def slopes(rows):
    return [[entry.slope if isinstance(entry, Dual) else 0.0 for entry in row] for row in rows]


def differences(make, angle, step=1e-6):
    ahead, behind = make(angle + step), make(angle - step)
    return [
        [(a - b) / (2.0 * step) for a, b in zip(*rows, strict=True)]
        for rows in zip(ahead, behind, strict=True)
    ]


def makers():
    yield rot_x
    yield rot_y
    yield rot_z
    yield lambda a: multiply(rot_x(a), rot_y(2.0 * a), rot_z(a))
    yield lambda a: RPY(a, 0.3, 2.0 * a).rotation()
    yield lambda a: EulerZYZ(a, a, 0.2).rotation()
    yield lambda a: AxisAngle((1.0, 2.0, 2.0), a).rotation()
    yield lambda a: compose(transform(rot_x(a), (1.0, 2.0, 3.0)), translation(10.0 * a, 0.0, 5.0))
    yield lambda a: invert(transform(rot_x(a), (a, 2.0, 3.0)))
    yield lambda a: (transform_point(transform(rot_z(a), (a, 0.0, 0.0)), (a, 1.0, 2.0)),)


@pytest.mark.parametrize("make", makers())
@given(angle=any_angle)
def test_a_matrix_of_dual_numbers_is_the_matrix_and_its_derivative(make, angle):
    found = slopes(make(Dual(angle, 1.0)))
    expected = differences(make, angle)
    for row, other in zip(found, expected, strict=True):
        assert row == pytest.approx(other, abs=1e-6)


def test_lengths_and_angles_of_dual_numbers_have_their_slopes():
    turning = (Dual(3.0, -4.0), Dual(4.0, 3.0), 0.0)  # one rad/s about Z, at the length 5
    assert norm(turning) == Dual(5.0, 0.0)
    assert angle_between(X_AXIS, turning).slope == pytest.approx(1.0)
    hand = position_of(compose(transform(rot_z(Dual(0.0, 1.0)), (0, 0, 0)), translation(7.0, 0, 0)))
    assert hand[1] == Dual(0.0, 7.0)
