"""Frame assignment: from joint axes to a link table, in both conventions."""

import math
from itertools import pairwise

import pytest
from chain_cases import (
    ALPHA_II,
    ALPHA_II_AXES,
    ALPHA_II_TOOL,
    ASKEW,
    chains_and_values,
    gap,
    joint_axes,
)
from hypothesis import given
from hypothesis import strategies as st

from kinematics.chains.assignment import JointAxis, Relation, assign_frames, relate
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.rotations import from_columns
from kinematics.frames.transforms import IN_PLACE, transform
from kinematics.frames.vectors import add, cross, distance, dot, norm, scale, subtract

BOTH = pytest.mark.parametrize("convention", Convention)


def turned(point, line, angle):
    """Rodrigues' rotation of a point about a line: an oracle that knows no link tables."""
    arm = subtract(point, line.point)
    along = scale(dot(arm, line.direction) * (1.0 - math.cos(angle)), line.direction)
    across = scale(math.sin(angle), cross(line.direction, arm))
    return add(line.point, add(scale(math.cos(angle), arm), add(across, along)))


def moved(axes, tool, values):
    """The tool's frame after every joint has moved, the last one first."""
    origin = tuple(row[3] for row in tool[:3])
    points = [origin, *(add(origin, tuple(row[c] for row in tool[:3])) for c in range(3))]
    for axis, value in reversed(list(zip(axes, values, strict=True))):
        if axis.kind is JointKind.REVOLUTE:
            points = [turned(point, axis.line, value) for point in points]
        else:
            points = [add(point, scale(value, axis.line.direction)) for point in points]
    x, y, z = (subtract(point, points[0]) for point in points[1:])
    return transform(from_columns(x, y, z), points[0])


tools = st.sampled_from([IN_PLACE, ASKEW, ALPHA_II_TOOL])


@given(st.lists(joint_axes, min_size=1, max_size=6), tools, st.sampled_from(Convention), st.data())
def test_the_chain_moves_as_the_axes_do(axes, tool, convention, data):
    values = data.draw(st.tuples(*[st.floats(-3.0, 3.0)] * len(axes)))
    chain = assign_frames(axes, tool, convention).chain
    assert gap(chain.fk(chain.zero), tool) < 1e-6
    assert gap(chain.fk(values), moved(axes, tool, values)) < 1e-6


@given(chains_and_values(most=5), st.sampled_from(Convention))
def test_any_chain_is_assigned_again_from_its_own_axes(case, convention):
    chain, values = case
    axes = [
        JointAxis(point, direction, kind)
        for (point, direction), kind in zip(chain.axes(chain.zero), chain.kinds, strict=True)
    ]
    if any(1e-10 < norm(cross(a.direction, b.direction)) < 1e-3 for a, b in pairwise(axes)):
        return  # nearly parallel: the common normal is where rounding puts it
    again = assign_frames(axes, chain.fk(chain.zero), convention).chain
    assert gap(again.fk(values), chain.fk(values)) < 1e-4


def test_the_alpha_ii_has_the_table_of_the_notes():
    found = assign_frames(ALPHA_II_AXES, ALPHA_II_TOOL, name="Alpha II")
    links = found.chain.links
    assert [math.degrees(link.alpha_rad) for link in links] == [-90, 0, 0, -90, 0]
    assert [link.d_mm for link in links] == pytest.approx([215, 0, 0, 0, 129.5])
    assert [link.a_mm for link in links] == pytest.approx([0, 177.8, 177.8, 0, 0])
    # the notes: only between x3 and x4 is there an angle in this position
    assert [math.degrees(link.theta_rad) for link in links] == [0, 0, 0, -90, 0]
    assert found.chain.tool == IN_PLACE
    assert found.chain.joint_names == ALPHA_II.joint_names


def test_the_alpha_ii_in_craig_s_convention():
    chain = assign_frames(ALPHA_II_AXES, ALPHA_II_TOOL, Convention.CRAIG).chain
    assert [math.degrees(link.alpha_rad) for link in chain.links] == [0, -90, 0, 0, -90]
    assert [link.a_mm for link in chain.links] == pytest.approx([0, 0, 177.8, 177.8, 0])
    assert [link.d_mm for link in chain.links] == [0, 0, 0, 0, 0]
    assert chain.base[2][3] == 215.0
    assert chain.tool[2][3] == pytest.approx(129.5)


def test_the_planar_arm_of_craig_s_figure():
    axes = [JointAxis((x, 0, 0), (0, 0, 1)) for x in (0, 300, 500)]
    found = assign_frames(axes, IN_PLACE, Convention.CRAIG)
    assert [link.a_mm for link in found.chain.links] == [0, 300, 200]
    assert {(link.alpha_rad, link.d_mm, link.theta_rad) for link in found.chain.links} == {
        (0, 0, 0)
    }


@BOTH
def test_a_slide_and_a_tool_askew_are_stated(convention):
    axes = [JointAxis((0, 0, 0), (0, 0, 1)), JointAxis((9, 0, 0), (1, 0, 0), JointKind.PRISMATIC)]
    found = assign_frames([*axes, axes[0]], ASKEW, convention)
    sentences = " ".join(str(choice) for choice in found.choices)
    assert "a slide has a direction and no place" in sentences
    if convention is Convention.STANDARD:
        assert "frame 3: four parameters do not lead to the tool's frame" in sentences


@given(joint_axes, joint_axes)
def test_the_common_normal_is_normal_to_both_axes(one, other):
    pair = relate(one.line, other.line, (7.0, 8.0, 9.0))
    normal = subtract(pair.far, pair.near)
    assert abs(dot(normal, one.line.direction)) < 1e-6
    assert abs(dot(normal, other.line.direction)) < 1e-6
    assert distance(one.line.foot(pair.near), pair.near) < 1e-6
    assert distance(other.line.foot(pair.far), pair.far) < 1e-6
    apart = pair.relation in (Relation.SKEW, Relation.PARALLEL)
    assert apart == (norm(normal) > 1e-6)
