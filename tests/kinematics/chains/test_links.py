"""Links: the A matrix in both conventions, and the eight types of section 2."""

import math

import pytest
from chain_cases import QUARTER, angles, gap, lengths
from hypothesis import given
from hypothesis import strategies as st

from kinematics.chains.links import LINK_TYPES, Convention, DHLink, JointKind, a_matrix, link_type
from kinematics.errors import BadNumber, KinematicsError
from kinematics.frames.rotations import rot_x, rot_z
from kinematics.frames.transforms import compose, invert, position_of, transform, translation

ORIGIN = (0.0, 0.0, 0.0)


@given(angles, lengths, lengths, angles)
def test_the_a_matrix_is_the_product_of_its_four_moves(theta, d, a, alpha):
    turn, twist = transform(rot_z(theta), ORIGIN), transform(rot_x(alpha), ORIGIN)
    along_z, along_x = translation(0.0, 0.0, d), translation(a, 0.0, 0.0)
    standard = compose(turn, along_z, along_x, twist)
    craig = compose(twist, along_x, turn, along_z)
    assert gap(a_matrix(theta, d, a, alpha), standard) < 1e-9
    assert gap(a_matrix(theta, d, a, alpha, Convention.CRAIG), craig) < 1e-9


@given(angles, lengths, lengths, angles)
def test_the_two_conventions_are_each_other_read_backwards(theta, d, a, alpha):
    standard = a_matrix(theta, d, a, alpha)
    craig = a_matrix(-theta, -d, -a, -alpha, Convention.CRAIG)
    assert gap(invert(standard), craig) < 1e-9


def test_a_quarter_turn_of_twist_leaves_exact_zeros():
    matrix = a_matrix(0.3, 10.0, 0.0, math.radians(90))
    c, s = math.cos(0.3), math.sin(0.3)
    assert matrix == ((c, 0, s, 0), (s, 0, -c, 0), (0, 1, 0, 10.0), (0, 0, 0, 1))


@given(st.floats(-3, 3), st.floats(-1, 1))
def test_a_revolute_joint_varies_the_angle_and_a_prismatic_one_the_distance(value, offset):
    turning = DHLink(0.5, 7.0, 3.0, 0.2, JointKind.REVOLUTE, offset)
    sliding = DHLink(0.5, 7.0, 3.0, 0.2, JointKind.PRISMATIC, offset)
    assert turning.parameters(value) == (0.5 + value + offset, 7.0, 3.0, 0.2)
    assert sliding.parameters(value) == (0.5, 7.0 + value + offset, 3.0, 0.2)
    assert turning.kind.unit == "rad"
    assert sliding.kind.unit == "mm"


@pytest.mark.parametrize("name", ["theta_rad", "d_mm", "a_mm", "alpha_rad", "offset", "low"])
@pytest.mark.parametrize("value", [math.nan, "1", None])
def test_a_parameter_that_is_no_number_is_named(name, value):
    with pytest.raises(BadNumber, match=name):
        DHLink(**{name: value})


def test_limits_in_the_wrong_order_are_refused():
    with pytest.raises(KinematicsError, match=r"low limit \(3 mm\).*\(2 mm\)"):
        DHLink(kind=JointKind.PRISMATIC, low=3.0, high=2.0)


def test_only_a_joint_that_ends_has_limits():
    assert not DHLink().has_limits
    assert DHLink(low=-1.0).has_limits


def test_the_eight_types_are_the_table_of_section_2():
    table = {
        number: (one.near.value[0], one.far.value[0], one.variable, one.has_length,
                 one.has_distance, math.degrees(one.alpha_rad))
        for number, one in LINK_TYPES.items()
    }  # fmt: skip
    assert table == {
        1: ("r", "r", "theta", True, False, 0),
        2: ("r", "r", "theta", True, False, 90),
        3: ("r", "r", "theta", False, True, 90),
        4: ("r", "r", "theta", False, False, 90),
        5: ("p", "p", "d", False, False, 90),
        6: ("r", "p", "theta", False, True, 90),
        7: ("r", "p", "theta", True, False, 0),
        8: ("p", "r", "d", False, False, 90),
    }


@pytest.mark.parametrize("number", range(1, 9))
def test_a_type_says_how_its_two_axes_lie(number):
    kind = link_type(number)
    link = kind.link(a_mm=30.0 if kind.has_length else 0.0, d_mm=20.0 if kind.has_distance else 0.0)
    frame = link.matrix(0.4)
    far_axis = (frame[0][2], frame[1][2], frame[2][2])
    assert far_axis[2] == pytest.approx(math.cos(kind.alpha_rad), abs=1e-12)
    off_axis_mm = math.hypot(*position_of(frame)[:2])
    assert off_axis_mm == pytest.approx(30.0 if kind.has_length else 0.0)
    parallel, intersect = "parallel" in kind.sentence, "intersect" in kind.sentence
    assert not parallel or kind.alpha_rad == 0.0
    assert not intersect or (kind.alpha_rad == QUARTER and off_axis_mm == 0.0)


C, S, H = 0.8, 0.6, math.atan2(0.6, 0.8)
"""A joint at an angle whose cosine and sine are short decimals."""


@pytest.mark.parametrize(
    ("number", "constants", "value", "matrix"),
    [  # by hand from section 6: the columns are x and z of the far frame, and its origin between
        (1, {"a_mm": 50}, H, ((C, -S, 0, 40), (S, C, 0, 30), (0, 0, 1, 0))),
        (2, {"a_mm": 50}, H, ((C, 0, S, 40), (S, 0, -C, 30), (0, 1, 0, 0))),
        (3, {"d_mm": 20}, H, ((C, 0, S, 0), (S, 0, -C, 0), (0, 1, 0, 20))),
        (4, {}, H, ((C, 0, S, 0), (S, 0, -C, 0), (0, 1, 0, 0))),
        (5, {}, 35.0, ((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 35))),
        (6, {"d_mm": 20}, H, ((C, 0, S, 0), (S, 0, -C, 0), (0, 1, 0, 20))),
        (7, {"a_mm": 50}, H, ((C, -S, 0, 40), (S, C, 0, 30), (0, 0, 1, 0))),
        (8, {}, 35.0, ((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 35))),
    ],
)
def test_the_a_matrix_of_each_type_in_numbers(number, constants, value, matrix):
    made = link_type(number).link(**constants).matrix(value)
    assert gap(made, (*matrix, (0, 0, 0, 1))) < 1e-12


@pytest.mark.parametrize(
    ("number", "constants", "value", "far_value", "point"),
    [  # 10 mm further along the far axis, or from the far joint along its link
        (1, {"a_mm": 50}, H, math.pi / 2, (34, 38, 0)),
        (2, {"a_mm": 50}, H, math.pi / 2, (40, 30, 10)),
        (3, {"d_mm": 20}, H, 0.0, (8, 6, 20)),
        (4, {}, H, math.pi / 2, (0, 0, 10)),
        (5, {}, 35.0, 10.0, (0, -10, 35)),
        (6, {"d_mm": 20}, H, 10.0, (6, -8, 20)),
        (7, {"a_mm": 50}, H, 10.0, (40, 30, 10)),
        (8, {}, 35.0, math.pi / 2, (0, 0, 45)),
    ],
)
def test_a_link_of_each_type_with_a_second_one_reaches_a_point_found_by_hand(
    number, constants, value, far_value, point
):
    kind = link_type(number)
    turns = kind.far is JointKind.REVOLUTE
    second = DHLink(a_mm=10.0) if turns else DHLink(kind=JointKind.PRISMATIC)
    tip = compose(kind.link(**constants).matrix(value), second.matrix(far_value))
    assert position_of(tip) == pytest.approx(point, abs=1e-12)


def test_a_type_refuses_a_length_that_it_has_not():
    with pytest.raises(KinematicsError, match="type 4 has no constant a, so 12 mm"):
        link_type(4).link(a_mm=12)
    with pytest.raises(KinematicsError, match="type 5 has no constant d"):
        link_type(5).link(d_mm=1)
    with pytest.raises(KinematicsError, match="1 to 8"):
        link_type(9)
