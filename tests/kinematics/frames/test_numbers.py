"""Functions of numbers: floats go to math, other kinds are asked themselves."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematics.frames import numbers
from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD, atan2, cos_sin, is_own_kind


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


@pytest.mark.parametrize("name", ["sin", "cos", "sqrt", "acos"])
@pytest.mark.parametrize("value", [0.5, 1, True])
def test_plain_numbers_go_to_math(name, value):
    assert getattr(numbers, name)(value) == getattr(math, name)(value)


@pytest.mark.parametrize("name", ["sin", "cos", "sqrt", "acos"])
def test_a_number_of_another_kind_is_asked_itself(name):
    assert getattr(numbers, name)(Own()) == f"own {name}"


def test_either_side_of_a_direction_may_be_of_another_kind():
    assert atan2(1.0, -1.0) == math.atan2(1.0, -1.0)
    assert atan2(Own(), 1.0) == "own atan2 of float"
    assert atan2(1, Own()) == "own atan2 with int"
    assert atan2(Own(), Own()) == "own atan2 of Own"


def test_only_what_brings_its_functions_is_of_another_kind():
    assert is_own_kind(Own())
    assert not any(map(is_own_kind, (0.0, 1, True, "1", None)))


@pytest.mark.parametrize("quarters", range(-5, 6))
@pytest.mark.parametrize("off", [0.0, QUARTER_TOLERANCE_RAD / 2, -QUARTER_TOLERANCE_RAD / 2])
def test_whole_quarter_turns_are_exact(quarters, off):
    cosine, sine = cos_sin(quarters * math.pi / 2 + off)
    assert {abs(cosine), abs(sine)} == {0.0, 1.0}
    assert (cosine, sine) == pytest.approx(
        (math.cos(quarters * math.pi / 2), math.sin(quarters * math.pi / 2)), abs=1e-12
    )


@given(st.floats(-10.0, 10.0))
def test_any_other_angle_keeps_its_cosine_and_sine(angle):
    assert cos_sin(angle) == pytest.approx((math.cos(angle), math.sin(angle)), abs=1e-11)


def test_a_constant_of_another_kind_is_asked_itself():
    assert cos_sin(Own()) == ("own cos", "own sin")
