"""Links: the A matrix in both conventions, and the eight types of section 2."""

import math
from dataclasses import replace

import pytest
from amounts import every_row
from chain_cases import (
    ALPHA_II,
    MINI_MOVER,
    QUARTER,
    angles,
    chains_and_values,
    gap,
    lengths,
)
from hypothesis import given
from hypothesis import strategies as st

from kinematics.chains.chain import Chain, table_text
from kinematics.chains.links import Convention, DHLink, JointKind, a_matrix
from kinematics.errors import BadNumber
from kinematics.frames.rotations import rot_x, rot_z
from kinematics.frames.transforms import compose, invert, position_of, transform, translation
from kinematics.frames.vectors import cross, distance, norm, subtract

ORIGIN = (0.0, 0.0, 0.0)
TURNS, SLIDES = JointKind.REVOLUTE, JointKind.PRISMATIC


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


@every_row("name", ["theta_rad", "d_mm", "a_mm", "alpha_rad", "offset", "low"])
@every_row("value", [math.nan, "1", None])
def test_a_parameter_that_is_no_number_is_named(name, value):
    with pytest.raises(BadNumber, match=name):
        DHLink(**{name: value})


TYPES = {
    1: lambda a, _: DHLink(a_mm=a),
    2: lambda a, _: DHLink(a_mm=a, alpha_rad=QUARTER),
    3: lambda _, d: DHLink(d_mm=d, alpha_rad=QUARTER),
    4: lambda *_: DHLink(alpha_rad=QUARTER),
    5: lambda *_: DHLink(alpha_rad=QUARTER, kind=SLIDES),
    6: lambda _, d: DHLink(d_mm=d, alpha_rad=QUARTER),
    7: lambda a, _: DHLink(a_mm=a),
    8: lambda *_: DHLink(alpha_rad=QUARTER, kind=SLIDES),
}
"""The eight link types of section 2, of a length and a distance."""

C, S, H = 0.8, 0.6, math.atan2(0.6, 0.8)
"""A joint at an angle whose cosine and sine are short decimals."""


@every_row(
    "number, value, matrix",
    [  # by hand from section 6: the columns are x and z of the far frame, and its origin between
        (1, H, ((C, -S, 0, 40), (S, C, 0, 30), (0, 0, 1, 0))),
        (2, H, ((C, 0, S, 40), (S, 0, -C, 30), (0, 1, 0, 0))),
        (3, H, ((C, 0, S, 0), (S, 0, -C, 0), (0, 1, 0, 20))),
        (4, H, ((C, 0, S, 0), (S, 0, -C, 0), (0, 1, 0, 0))),
        (5, 35.0, ((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 35))),
        (6, H, ((C, 0, S, 0), (S, 0, -C, 0), (0, 1, 0, 20))),
        (7, H, ((C, -S, 0, 40), (S, C, 0, 30), (0, 0, 1, 0))),
        (8, 35.0, ((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 35))),
    ],
)
def test_the_a_matrix_of_each_type_in_numbers(number, value, matrix):
    made = TYPES[number](50.0, 20.0).matrix(value)
    assert gap(made, (*matrix, (0, 0, 0, 1))) < 1e-12


@every_row(
    "number, far, value, far_value, point",
    [  # 10 mm further along the far axis, or from the far joint along its link
        (1, TURNS, H, math.pi / 2, (34, 38, 0)),
        (2, TURNS, H, math.pi / 2, (40, 30, 10)),
        (3, TURNS, H, 0.0, (8, 6, 20)),
        (4, TURNS, H, math.pi / 2, (0, 0, 10)),
        (5, SLIDES, 35.0, 10.0, (0, -10, 35)),
        (6, SLIDES, H, 10.0, (6, -8, 20)),
        (7, SLIDES, H, 10.0, (40, 30, 10)),
        (8, TURNS, 35.0, math.pi / 2, (0, 0, 45)),
    ],
)
def test_a_link_of_each_type_with_a_second_one_reaches_a_point_found_by_hand(
    number, far, value, far_value, point
):
    second = DHLink(a_mm=10.0) if far is TURNS else DHLink(kind=SLIDES)
    tip = compose(TYPES[number](50.0, 20.0).matrix(value), second.matrix(far_value))
    assert position_of(tip) == pytest.approx(point, abs=1e-12)


# Chains: the product of the A matrices, frames, axes, limits, tables, numbers of other kinds.


@given(chains_and_values())
def test_the_frames_lead_from_the_base_to_the_tool(case):
    chain, values = case
    frames = chain.frames(values)
    assert len(frames) == len(chain) + 1
    assert frames[0] == chain.base
    assert gap(chain.fk(values), compose(frames[-1], chain.tool)) < 1e-9


@given(chains_and_values(), st.data(), st.floats(-1.0, 1.0))
def test_moving_a_joint_moves_what_follows_about_or_along_its_axis(case, data, step):
    chain, values = case
    index = data.draw(st.integers(0, len(chain) - 1))
    moved = [*values[:index], values[index] + step, *values[index + 1 :]]
    point, axis = chain.axes(values)[index]
    before, after = position_of(chain.fk(values)), position_of(chain.fk(moved))
    if chain.kinds[index] is JointKind.PRISMATIC:
        expected = tuple(b + step * a for b, a in zip(before, axis, strict=True))
        assert after == pytest.approx(expected, abs=1e-9)
    else:
        arms = subtract(before, point), subtract(after, point)
        off_axis = [norm(cross(axis, arm)) for arm in arms]
        assert off_axis[0] == pytest.approx(off_axis[1], abs=1e-7)


def test_the_alpha_ii_in_its_zero_position():
    frame = ALPHA_II.fk(ALPHA_II.zero)
    assert position_of(frame) == pytest.approx((355.6, 0.0, 85.5))
    assert frame[2][2] == -1.0  # the hand points down


@given(chains_and_values())
def test_no_posture_leaves_the_longest_reach_and_the_sphere_of_reach(case):
    chain, values = case
    links = tuple(
        replace(link, low=-3.0, high=3.0) if link.kind is JointKind.PRISMATIC else link
        for link in chain.links
    )
    bounded = replace(chain, links=links)
    tip = position_of(bounded.fk(values))
    assert distance(tip, position_of(bounded.base)) <= bounded.longest_reach_mm + 1e-9
    centre, radius = bounded.reach_sphere
    assert distance(tip, centre) <= radius + 1e-9


def test_a_slide_without_an_end_reaches_any_distance():
    assert Chain((DHLink(kind=JointKind.PRISMATIC),)).longest_reach_mm == math.inf


def test_limits_name_the_joint_and_its_bound():
    values = (0.0, 0.0, 0.5, 0.0, 0.0)
    (broken,) = MINI_MOVER.violations(values)
    assert (broken.joint, broken.value, broken.bound, broken.unit) == ("elbow", 0.5, 0.0, "rad")
    assert broken.excess == 0.5
    assert MINI_MOVER.clamp(values) == MINI_MOVER.zero
    assert not MINI_MOVER.violations(MINI_MOVER.zero)


def test_a_prismatic_limit_is_in_mm():
    chain = Chain((DHLink(kind=JointKind.PRISMATIC, low=0.0, high=80.0),))
    (broken,) = chain.violations([90.0])
    assert (broken.value, broken.bound, broken.unit) == (90.0, 80.0, "mm")


def test_the_table_as_text():
    assert table_text(ALPHA_II).splitlines() == [
        "Alpha II: standard convention, mm and degrees, * varies",
        "joint     theta      d      a  alpha",
        "base         0*    215      0    -90",
        "shoulder     0*      0  177.8      0",
        "elbow        0*      0  177.8      0",
        "pitch        0*      0      0    -90",
        "roll         0*  129.5      0      0",
    ]


def test_the_text_says_which_convention_and_which_number_varies():
    slide = DHLink(0.0, 5.0, 0.0, QUARTER, JointKind.PRISMATIC)
    text = table_text(Chain((slide,), Convention.CRAIG))
    assert "craig convention" in text
    assert "a and alpha of the link before" in text
    assert "5*" in text


def test_the_sphere_of_reach_is_about_the_shoulder():
    centre, radius = MINI_MOVER.reach_sphere
    assert centre == (0.0, 0.0, 195.0)
    assert radius == pytest.approx(452.1)
