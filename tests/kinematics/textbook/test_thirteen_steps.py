"""Frames and link table from joint axes, step by step, in both conventions."""

import math

import pytest
from amounts import every_row
from chain_cases import ALPHA_II_AXES, ALPHA_II_TOOL, joint_axes
from hypothesis import given
from hypothesis import strategies as st

from kinematics.chains.assignment import (
    JointAxis,
    assign_frames,
    tip_frame,
)
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.frames.vectors import add, cross, distance, norm, scale, subtract
from kinematics.textbook.thirteen_steps import assignment_steps

BOTH = pytest.mark.parametrize("convention", Convention)
UP = JointAxis((0, 0, 0), (0, 0, 1))
TOOL = tip_frame(UP, (0, 0, 300))


def assigned(axes, tool=TOOL, convention=Convention.STANDARD):
    return assign_frames(axes, tool, convention)


def step(found, number, index):
    (taken,) = [
        one for one in assignment_steps(found) if (one.number, one.index) == (number, index)
    ]
    return taken


@BOTH
@pytest.mark.parametrize("count", [1, 2, 5])
def test_every_step_is_taken_once_for_each_frame_and_link(count, convention):
    found = assigned(ALPHA_II_AXES[:count], ALPHA_II_TOOL, convention)
    taken = [(one.number, one.index) for one in assignment_steps(found)]
    frames = [(number, k) for k in range(1, count) for number in range(3, 8)]
    links = [(number, k) for k in range(1, count + 1) for number in range(9, 14)]
    assert taken == [(1, 0), (2, 0), *frames, (8, count), *links]


@BOTH
@pytest.mark.parametrize(
    ("number", "index", "standard", "craig"),
    [
        (2, 0, "z0 = (0, 0, 1)", "z0 = (0, 0, 1)"),
        (3, 1, "z1 = (0, 1, 0)", "z1 = (0, 0, 1)"),
        (4, 1, "axes 1 and 2 intersect at 90°", "axes 1 and 2 intersect at 90°"),
        (4, 1, "L1 = (0, 0, 215) mm", "L1 = (0, 0, 215) mm"),
        (4, 2, "L2 = (177.8, 0, 215) mm", "L2 = (0, 0, 215) mm"),
        (5, 2, "x2 = (1, 0, 0)", "x2 = (1, 0, 0)"),
        (6, 2, "y2 = (0, 0, -1)", "y2 = (0, 0, -1)"),
        (7, 3, "go on with step 3", "go on with step 3"),
        (7, 4, "go on with step 8", "go on with step 8"),
        (8, 5, "L5 = (485.1, 0, 215) mm", "L5 = (355.6, 0, 215) mm"),
        (9, 3, "b3 = (177.8, 0, 215) mm", "b3 = (177.8, 0, 215) mm"),
        (10, 4, "theta4 = -90° (the joint's variable, added to this)", "theta4 = -90° (the"),
        (11, 1, "d1 = 215 mm", "d1 = 0 mm"),
        (12, 3, "a3 = 177.8 mm", "a2 = 177.8 mm"),
        (13, 1, "alpha1 = -90°", "alpha0 = 0°"),
    ],
)
def test_a_step_of_the_alpha_ii_states_what_it_gives(number, index, standard, craig, convention):
    found = assigned(ALPHA_II_AXES, ALPHA_II_TOOL, convention)
    said = " ".join(step(found, number, index).lines)
    assert said.startswith(f"{number}. ")
    assert (standard if convention is Convention.STANDARD else craig) in said


def leaning(lean):
    return JointAxis((80, 0, 0), (0, math.sin(lean), math.cos(lean)))


@BOTH
@pytest.mark.parametrize(
    ("second", "words_4", "words_5"),
    [
        (JointAxis((50, 20, 30), (1, 1, 0)), "are skew: 21.21 mm apart, at 90°", "x1 = (0.7071"),
        (JointAxis((50, 20, 30), (1, 1, 0)), "common normal from (0, 0, 30) mm to (15, -15, 30)",
         "x1 = (0.7071, -0.7071, 0)"),
        (JointAxis((0, 0, 70), (1, 0, 1)), "intersect at 45°", "x may point either way"),
        (JointAxis((80, 0, 70), (0, 0, 2)), "are parallel, 80 mm apart", "x1 = (1, 0, 0)"),
        (JointAxis((80, 0, 70), (0, 0, -1)), "parallel, 80 mm apart, in opposite dir", "x1 = (1,"),
        (JointAxis((0, 0, 70), (0, 0, 1)), "are the same line", "1 and 2 are the same, so x may"),
        (leaning(1e-8), "nearly parallel (1e-08 rad apart), and taken as parallel", "x1 = (1, 0"),
        (leaning(1e-5), "only 1e-05 rad from parallel, and their common", "x1 = (1, 0, 0)"),
    ],
)  # fmt: skip
def test_how_two_axes_lie_is_named_where_it_matters(second, words_4, words_5, convention):
    found = assigned((UP, second), convention=convention)
    assert words_4 in " ".join(step(found, 4, 1).lines)
    assert words_5 in " ".join(step(found, 5, 1).lines)


@given(st.lists(joint_axes, min_size=1, max_size=6), st.sampled_from(Convention))
def test_each_point_b_lies_on_its_two_axes_and_measures_d_and_a(axes, convention):
    found = assigned(axes, tip_frame(axes[-1], (30.0, 60.0, -20.0)), convention)
    origins = [position_of(frame) for frame in found.frames]
    for k, (point, link) in enumerate(zip(found.points, found.chain.links, strict=True), 1):
        near, far = (k - 1, k) if convention is Convention.STANDARD else (k, k - 1)
        z, x = (
            columns(rotation_of(found.frames[near]))[2],
            columns(rotation_of(found.frames[far]))[0],
        )
        sign = 1.0 if convention is Convention.STANDARD else -1.0
        assert distance(point, add(origins[near], scale(sign * link.d_mm, z))) < 1e-5
        assert distance(point, add(origins[far], scale(-sign * link.a_mm, x))) < 1e-5
        axis = found.zero.axes[k - 1].line
        if convention is Convention.CRAIG or found.zero.axes[k - 1].kind is JointKind.REVOLUTE:
            assert norm(cross(subtract(point, axis.point), axis.direction)) < 1e-5


@every_row(
    "last, point, more, z, x",
    [
        (UP, (0, 0, 50), {}, (0, 0, 1), (1, 0, 0)),
        (UP, (30, 40, 50), {}, (0, 0, 1), (0.6, 0.8, 0)),
        (JointAxis((0, 0, 0), (2, 0, 0)), (9, 0, 0), {}, (1, 0, 0), (0, 1, 0)),
        (UP, (30, 0, 0), {"approach": (0, 5, 0)}, (0, 1, 0), (-1, 0, 0)),
        (UP, (30, 0, 0), {"approach": (0, 0, -1)}, (0, 0, -1), (1, 0, 0)),
        (UP, (30, 0, 0), {"normal": (0, 3, 0)}, (0, 0, 1), (0, 1, 0)),
    ],
)
def test_a_tip_is_turned_as_four_parameters_need_it(last, point, more, z, x):
    frame = tip_frame(last, point, **more)
    assert position_of(frame) == point
    made = columns(rotation_of(frame))
    assert (made[2], made[0]) == (pytest.approx(z), pytest.approx(x))
    if "normal" not in more:
        assert assigned((last,), frame).choices[-1].step != 8, "four parameters lead there"
