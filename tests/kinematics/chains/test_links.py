"""Links: the A matrix in both conventions, and the eight types of section 2."""

import math
from dataclasses import replace

import numpy as np
import pytest
from amounts import every_row
from chain_cases import (
    ALPHA_II,
    QUARTER,
    angles,
    chains_and_values,
    gap,
    lengths,
)
from hypothesis import given

from kinematics.chains.chain import Chain, table_text
from kinematics.chains.evaluation import evaluator
from kinematics.chains.links import Convention, DHLink, JointKind, a_matrix
from kinematics.chains.many import reach_maps
from kinematics.errors import KinematicsError
from kinematics.frames.rotations import rot_x, rot_z
from kinematics.frames.transforms import compose, position_of, transform, translation
from kinematics.frames.vectors import distance

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


@given(chains_and_values())
def test_the_evaluator_s_frame_is_the_product_of_the_matrices(case):
    chain, values = case
    assert gap(evaluator(chain).fk(values), chain.fk(values)) < 1e-9


# Places that chains reach.


def test_a_reach_without_end_is_refused():
    with pytest.raises(KinematicsError, match="slides without limits"):
        reach_maps(Chain((DHLink(kind=JointKind.PRISMATIC),)), ((0, 1),), 10, 10)


def test_a_map_shows_one_place_of_each_cell_of_a_ring_and_how_far_it_reaches():
    cells, ring = 40, Chain((DHLink(a_mm=200.0), DHLink(a_mm=150.0)))
    found, edge = reach_maps(ring, ((0, 1), (0, 2)), 20_000, cells)
    radii = np.hypot(*found.T)
    assert 50.0 - 1e-9 <= radii.min() < 55.0
    assert 345.0 < radii.max() <= 350.0 + 1e-9
    size = np.ptp(found, axis=0).max() / cells
    shown = {tuple(cell) for cell in ((found - found.min(axis=0)) // size).tolist()}
    assert len(shown) <= len(found) <= len(shown) + 4
    assert len(found) > 0.9 * math.pi * (350**2 - 50**2) / size**2
    assert set(edge[:, 1]) == {0.0}
