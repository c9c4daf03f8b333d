"""Links: the A matrix in both conventions, and the eight types of section 2."""

import ast
import math
from dataclasses import replace

import numpy as np
import pytest
from amounts import every_row
from chain_cases import (
    ALPHA_II,
    QUARTER,
    angles,
    chains,
    chains_and_values,
    gap,
    lengths,
)
from hypothesis import given
from hypothesis import strategies as st

from kinematics.chains.chain import Chain, table_text
from kinematics.chains.generated import generated
from kinematics.chains.links import Convention, DHLink, JointKind, a_matrix
from kinematics.chains.many import BLOCK, reach_maps, spans_of
from kinematics.errors import KinematicsError
from kinematics.frames.rotations import rot_x, rot_z
from kinematics.frames.transforms import compose, invert, position_of, transform, translation
from kinematics.frames.vectors import cross, distance, norm, subtract
from kinematics.limits import spread_over
from kinematics.presets import PRESETS
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.systems.mini_movers import MINI_MOVER as BUILD
from kinematics.textbook.systems.mini_movers import with_arm

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


# Functions generated of a chain's table: the same as the product of the matrices, and fast.


@given(chains_and_values())
def test_the_generated_transform_is_the_product_of_the_matrices(case):
    chain, values = case
    assert gap(generated(chain).fk(values), chain.fk(values)) < 1e-9


@given(chains())
def test_the_source_is_straight_line_arithmetic(chain):
    allowed = (
        ast.Module, ast.FunctionDef, ast.arguments, ast.arg, ast.Assign, ast.Return, ast.Tuple,
        ast.Name, ast.Constant, ast.BinOp, ast.UnaryOp, ast.Call, ast.Load, ast.Store, ast.Add,
        ast.Sub, ast.Mult, ast.USub,
    )  # fmt: skip
    tree = ast.parse(generated(chain).source)
    assert all(isinstance(node, allowed) for node in ast.walk(tree))
    called = {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call)}
    assert called <= {"sin", "cos"}


# Places that chains reach, from some thousand postures and from a million.

REAL_ARMS = {
    **{name: with_arm(BUILD, PRESETS[name].arm).chain() for name in ("minimover5", "alpha2")},
    "puma": SYSTEMS["puma"].chain(),
}


def spread(chain, count):
    return list(spread_over(spans_of(chain), count).postures())


def sampled(chain, count):
    """The tips of the spread postures, one by one."""
    fk = generated(chain).fk
    return np.array([position_of(fk(posture)) for posture in spread(chain, count)])


def test_a_reach_without_end_is_refused():
    endless = Chain((DHLink(kind=JointKind.PRISMATIC),))
    for take in (spans_of, lambda chain: reach_maps(chain, ((0, 1),), 10, 10)):
        with pytest.raises(KinematicsError, match="slides without limits"):
            take(endless)
    with pytest.raises(KinematicsError, match="at least one posture"):
        spread_over(spans_of(Chain((DHLink(),))), 0)


@every_row("arm", REAL_ARMS.values(), ids=REAL_ARMS)
def test_a_map_shows_one_place_of_each_cell_and_how_far_the_arm_reaches(arm):
    cells, count, planes = 40, BLOCK + 900, ((0, 2), (0, 1), (1, 2))
    places = sampled(arm, count)
    for plane, found in zip(planes, reach_maps(arm, planes, count, cells), strict=True):
        tips = places[:, plane]
        low, high = tips.min(axis=0), tips.max(axis=0)
        np.testing.assert_allclose(found.min(axis=0), low, atol=1e-9)
        np.testing.assert_allclose(found.max(axis=0), high, atol=1e-9)
        size = (high - low).max() / cells
        shown, reached = cells_of(found, low, size, cells), cells_of(tips, low, size, cells)
        assert len(shown ^ reached) <= 2  # a place on the rim of two cells is in either
        assert len(found) <= len(shown) + 4
        for place in found[::50]:
            assert np.abs(tips - place).max(axis=1).min() < 1e-9


def cells_of(places, low, size, cells):
    return {tuple(cell) for cell in np.minimum((places - low) / size, cells - 1).astype(int)}
