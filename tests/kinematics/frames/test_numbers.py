"""Functions of numbers of any kind, and formulas on dual numbers, which give derivatives."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from frame_cases import any_angle
from hypothesis import given
from kinematics_cases import Dual

from kinematics.frames import numbers
from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD, atan2, cos_sin
from kinematics.frames.orientations import RPY, AxisAngle, EulerZYZ
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import (
    compose,
    invert,
    transform,
    transform_point,
    translation,
)


class Own:
    """A number of another kind that says what it was asked."""

    def sin(self):
        return "own sin"

    def cos(self):
        return "own cos"

    def sqrt(self):
        return "own sqrt"

    def acos(self):
        return "own acos"

    def atan2(self, x):
        return f"own atan2 of {type(x).__name__}"

    def atan2_of(self, y):
        return f"own atan2 with {type(y).__name__}"


@every_row("name", ["sin", "cos", "sqrt", "acos"])
def test_a_number_of_another_kind_is_asked_itself(name):
    assert getattr(numbers, name)(Own()) == f"own {name}"


def test_either_side_of_a_direction_may_be_of_another_kind():
    assert atan2(1.0, -1.0) == math.atan2(1.0, -1.0)
    assert atan2(Own(), 1.0) == "own atan2 of float"
    assert atan2(1, Own()) == "own atan2 with int"
    assert atan2(Own(), Own()) == "own atan2 of Own"


@every_row("quarters", range(-5, 6))
@every_row("off", [0.0, QUARTER_TOLERANCE_RAD / 2, -QUARTER_TOLERANCE_RAD / 2])
def test_whole_quarter_turns_are_exact(quarters, off):
    cosine, sine = cos_sin(quarters * math.pi / 2 + off)
    assert {abs(cosine), abs(sine)} == {0.0, 1.0}
    assert (cosine, sine) == pytest.approx(
        (math.cos(quarters * math.pi / 2), math.sin(quarters * math.pi / 2)), abs=1e-12
    )


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
    assert gap(found, expected) < 1e-6
