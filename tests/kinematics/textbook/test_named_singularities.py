"""Jacobians in a system's own coordinates, and the singularities that have names."""

import math

import pytest

from kinematics.chains.chain import chain_of_rows
from kinematics.frames.rotations import determinant, multiply, transpose
from kinematics.frames.transforms import rotation_of
from kinematics.textbook.study import (
    chain_rows,
    example_posture,
    judged,
    named_singularities,
    own_jacobian,
    own_rows,
)
from kinematics.textbook.systems import SYSTEMS

STEP = 1e-6
NAMES = list(SYSTEMS)


def condition_at(system, values):
    return judged(system.chain(), own_jacobian(system, values), own_rows(system))


def turned(system, one, other):
    """Return the small turn from one posture's hand to another's, about x, y and z."""
    by = multiply(rotation_of(system.fk(other)), transpose(rotation_of(system.fk(one))))
    return by[2][1], by[0][2], by[1][0]


@pytest.mark.parametrize("name", NAMES)
def test_the_jacobian_is_what_a_small_move_of_each_joint_does(name):
    system = SYSTEMS[name]
    here = example_posture(system.chain())
    columns = zip(*own_jacobian(system, here), strict=True)
    for joint, column in enumerate(columns):
        after, before = list(here), list(here)
        after[joint] += STEP
        before[joint] -= STEP
        ends = [system.goal_of(system.fk(tuple(one))) for one in (before, after)]
        done = [(b - a) / (2 * STEP) for a, b in zip(*ends, strict=True)]
        if name == "puma":  # its angles are no rates of turning
            done[3:] = [part / (2 * STEP) for part in turned(system, before, after)]
        assert column == pytest.approx(done, abs=2e-6 * max(1.0, *map(abs, done)))


@pytest.mark.parametrize(
    ("name", "values", "product"),
    [
        ("two-link-1", (30, 40), lambda q: 200 * 150 * math.sin(q[1])),
        ("three-link", (10, 20, 30), lambda q: 200 * 150 * math.sin(q[1])),
        ("two-link-4", (100, 30), lambda q: 150 * math.sin(q[1])),
    ],
)
def test_the_determinant_is_the_textbooks(name, values, product):
    system = SYSTEMS[name]
    joints = tuple(
        math.radians(one) if kind.unit == "rad" else float(one)
        for one, kind in zip(values, system.chain().kinds, strict=True)
    )
    rows = own_jacobian(system, joints)
    (a, b), (c, d) = rows[0][:2], rows[1][:2]
    size = determinant(rows) if len(rows) == 3 else a * d - b * c
    lengths = system.lengths()
    assert set(lengths.values()) <= {200.0, 150.0, 80.0}
    assert abs(size) == pytest.approx(abs(product(joints)))


AT = {
    "two-link-1": [(0.3, 0.0), (0.3, math.pi)],
    "two-link-2": [(0.3, math.pi / 2)],
    "two-link-3": [(0.3, 0.0)],
    "two-link-4": [(100.0, math.pi)],
    "three-link": [(0.3, 0.0, 0.5), (0.3, math.pi, 0.5)],
    "cylindrical": [(0.3, 100.0, 0.0)],
    "spherical": [(0.3, math.pi / 2, 100.0), (0.3, 0.4, 0.0)],
    "revolute": [(0.3, 0.4, 0.0), (0.3, 0.4, math.pi), (0.3, 0.0, 0.0)],
    "minimover5": [(0.3, 0.4, -math.pi, 0.2, 0.1), (0.3, 0.4, 0.0, 0.2, 0.1)],
    "alpha2-lecture": [(0.3, 0.4, math.pi, 0.2, 0.1), (0.3, 0.4, 0.0, 0.2, 0.1)],
    "puma": [
        (0.3, 0.4, math.pi / 2, 0.5, 0.6, 0.7),
        (0.3, 0.4, -math.pi / 2, 0.5, 0.6, 0.7),
        (0.3, 0.4, 0.5, 0.5, 0.0, 0.7),
    ],
}
"""Postures that stand in the singularities of each system, in the order that they are listed."""


@pytest.mark.parametrize(
    ("name", "index"), [(n, i) for n, at in AT.items() for i in range(len(at))]
)
def test_where_a_named_singularity_is_the_jacobian_loses_a_rank(name, index):
    system, values = SYSTEMS[name], AT[name][index]
    if name in ("minimover5", "alpha2-lecture"):
        index = ("folded", "straight")[index]
        lost = next(one for one in named_singularities(system, values) if index in one.reason)
    else:
        lost = named_singularities(system, values)[index]
    away = lost.distance_mm if lost.distance_rad is None else lost.distance_rad
    assert away == pytest.approx(0.0, abs=1e-9)
    assert condition_at(system, values).smallest < 1e-7


@pytest.mark.parametrize("name", NAMES)
def test_away_from_them_nothing_is_lost(name):
    system = SYSTEMS[name]
    here = example_posture(system.chain())
    found = named_singularities(system, here)
    assert not condition_at(system, here).is_singular
    for one in found:
        assert (one.distance_mm if one.distance_rad is None else one.distance_rad) > 1e-3
    assert bool(found) == (name not in ("two-link-5", "cartesian"))


def test_a_puma_over_its_base_is_singular_too():
    puma = SYSTEMS["puma"]
    # with the forearm hanging back over the shoulder: a2 cos(t2) + d4 sin(t2 + t3) = 0
    second = 0.4
    upper, forearm = puma.lengths()["a2"], puma.lengths()["d4"]
    third = math.asin(-upper * math.cos(second) / forearm) - second
    values = (0.3, second, third, 0.5, 0.6, 0.7)
    assert named_singularities(puma, values)[3].distance_mm == pytest.approx(0.0, abs=1e-9)
    assert condition_at(puma, values).smallest < 1e-7


def test_a_five_axis_arm_over_its_base_says_what_it_cannot_do():
    system = SYSTEMS["minimover5"]
    goal = (0.0, 0.0, 450.0, 0.3, 0.0)
    posture = system.ik(goal)[0].joints
    found = condition_at(system, posture)
    assert found.is_singular
    assert "moving base" in found.sentence


def test_a_planar_table_is_judged_in_its_plane():
    planar = chain_of_rows([{"a_mm": 200.0}, {"a_mm": 150.0}, {"a_mm": 80.0}])
    assert chain_rows(planar) == (0, 1)
    scara = chain_of_rows(
        [
            {"a_mm": 200.0},
            {"a_mm": 150.0, "alpha_deg": 180.0},
            {"kind": "prismatic", "low_mm": 0.0, "high_mm": 100.0},
            {},
        ]
    )
    assert chain_rows(scara) == (0, 1, 2, 5)
