"""Chains: the product of the A matrices, frames, axes, limits, tables, numbers of other kinds."""

import math
from dataclasses import replace

import pytest
from chain_cases import ALPHA_II, MINI_MOVER, QUARTER, chains, chains_and_values, gap
from hypothesis import example, given
from hypothesis import strategies as st

from kinematics.chains.chain import Chain, chain_of_rows, rows_of, table_text
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.errors import BadNumber, KinematicsError
from kinematics.frames.transforms import compose, position_of
from kinematics.frames.vectors import cross, distance, norm, subtract


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


def test_the_wrong_number_of_values_and_bad_ones_are_named():
    with pytest.raises(KinematicsError, match=r"5 numbers \(base, shoulder"):
        MINI_MOVER.fk((0.0, 0.0))
    with pytest.raises(BadNumber, match="elbow"):
        MINI_MOVER.fk((0.0, 0.0, math.nan, 0.0, 0.0))


@pytest.mark.parametrize("names", [("a",), ("a", "a")])
def test_names_must_fit_the_links(names):
    with pytest.raises(KinematicsError, match="2 different joint names"):
        Chain((DHLink(), DHLink()), joint_names=names)


@given(chains())
@example(MINI_MOVER)
def test_a_table_makes_the_chain_it_was_made_of(chain):
    again = chain_of_rows(
        rows_of(chain), convention=chain.convention, base=chain.base, tool=chain.tool
    )
    assert again.joint_names == chain.joint_names
    for one, other in zip(chain.links, again.links, strict=True):
        assert other.kind is one.kind
        assert other.parameters(0.3) == pytest.approx(one.parameters(0.3), abs=1e-11)
        assert (other.low, other.high) == pytest.approx((one.low, one.high))


def test_the_table_as_text():
    assert table_text(ALPHA_II).splitlines() == [
        "Alpha II: standard convention, * varies",
        "joint     theta/deg   d/mm   a/mm  alpha/deg",
        "base             0*    215      0        -90",
        "shoulder         0*      0  177.8          0",
        "elbow            0*      0  177.8          0",
        "pitch            0*      0      0        -90",
        "roll             0*  129.5      0          0",
    ]


def test_the_text_says_which_convention_and_which_number_varies():
    slide = DHLink(0.0, 5.0, 0.0, QUARTER, JointKind.PRISMATIC)
    text = table_text(Chain((slide,), Convention.CRAIG))
    assert "craig convention" in text
    assert "alpha before/deg" in text
    assert "5*" in text


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"alpa_deg": 90}, "row 1: a revolute joint has no 'alpa_deg'; did you mean 'alpha_deg'"),
        ({"kind": "prismatic", "low_deg": 0}, "a prismatic joint has no 'low_deg'"),
        ({"kind": "rotary"}, "revolute or prismatic, not 'rotary'"),
        ({"d_mm": "long"}, "d_mm must be a finite number"),
    ],
)
def test_a_row_that_cannot_be_read_is_explained(row, message):
    with pytest.raises(KinematicsError, match=message):
        chain_of_rows([row])


def test_the_sphere_of_reach_is_about_the_shoulder():
    centre, radius = MINI_MOVER.reach_sphere
    assert centre == (0.0, 0.0, 195.0)
    assert radius == pytest.approx(452.1)
