"""The pictures of a frame assignment: what each step adds, and nothing more."""

import re

import pytest

from armdrive.render.frame_steps import AXIS_WORD, StepDrawing
from kinematics.chains.assignment import JointAxis, assign_frames, tip_frame, zero_position
from kinematics.chains.links import Convention
from kinematics.textbook.systems import SYSTEMS, system
from kinematics.textbook.thirteen_steps import assignment_steps


def pictures(name, convention=Convention.STANDARD, *, braille=False):
    zero = zero_position(system(name).chain())
    found = assign_frames(zero.axes, zero.tool, convention)
    drawing = StepDrawing(found)
    return {
        (step.number, step.known.index): "\n".join(
            drawing.rows(step.known, 78, 30, braille=braille)
        )
        for step in assignment_steps(found)
    }


def labels(picture):
    return set(re.findall(r"[Lbxyz]\d", picture))


@pytest.mark.parametrize(
    ("step", "shown", "hidden"),
    [
        ((1, 0), set(), {"L0", "z0"}),
        ((2, 0), {"L0", "x0", "y0", "z0"}, {"L1"}),
        ((3, 1), {"L0", "x0", "z0"}, {"L1", "z1", "y0"}),
        ((4, 1), {"L0", "L1", "z1"}, {"x1", "y1"}),
        ((5, 1), {"L1", "z1", "x1"}, {"y1"}),
        ((6, 1), {"L1", "z1", "x1", "y1"}, {"b1"}),
        ((8, 2), {"L2", "x2", "y2", "z2"}, {"y1", "b1"}),
        ((9, 1), {"b1", "x0", "z0", "x1"}, {"b2", "y1", "x2"}),
        ((13, 2), {"b1", "b2", "z1", "x2"}, {"x0", "y2"}),
    ],
)
def test_a_picture_shows_what_is_known_by_then(step, shown, hidden):
    seen = labels(pictures("two-link-2")[step])
    assert shown <= seen
    assert not hidden & seen


@pytest.mark.parametrize("convention", Convention)
@pytest.mark.parametrize("name", SYSTEMS)
def test_every_step_of_every_system_is_drawn(name, convention):
    for braille in (True, False):
        drawn = pictures(name, convention, braille=braille)
        assert all(AXIS_WORD in picture for picture in drawn.values())


def test_frames_at_one_place_have_their_names_side_by_side():
    wrist = [JointAxis((0, 0, 0), direction) for direction in ((0, 0, 1), (0, 1, 0), (0, 0, 1))]
    found = assign_frames(wrist, tip_frame(wrist[-1], (0, 0, 0)))
    *_, last = assignment_steps(found)
    assert "L0 L1 L2 L3 b1 b2 b3" in "\n".join(
        StepDrawing(found).rows(last.known, 78, 24, braille=False)
    )
