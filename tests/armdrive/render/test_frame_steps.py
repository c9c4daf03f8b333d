"""The pictures of a frame assignment: what each frame and link adds, and nothing more."""

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
        step.stage: "\n".join(
            drawing.rows(step.index, 78, 30, linked=step.is_of_link, braille=braille)
        )
        for step in assignment_steps(found)[1:]
    }


def labels(picture):
    return set(re.findall(r"[Lbxyz]\d", picture))


@pytest.mark.parametrize(
    ("convention", "stage", "shown"),
    [
        ("standard", "Frame 0", "L0 x0 y0 z0"),
        ("standard", "Frame 1", "L0 x0 z0 L1 x1 y1 z1"),
        ("standard", "Frame 2", "L0 L1 x1 z1 L2 x2 y2 z2"),
        ("standard", "Link 1", "L0 x0 z0 L1 x1 z1 L2 b1"),
        ("standard", "Link 2", "L0 L1 x1 z1 L2 x2 z2 b1 b2"),
        ("craig", "Frame 0", ""),
        ("craig", "Frame 1", "L1 x1 y1 z1"),
        ("craig", "Frame 2", "L0 L1 x1 z1 L2 x2 y2 z2"),
    ],
)
def test_a_picture_shows_what_is_known_by_then(convention, stage, shown):
    drawn = pictures("two-link-2", Convention(convention))
    (picture,) = (rows for title, rows in drawn.items() if title.startswith(stage))
    assert labels(picture) == set(shown.split())


@pytest.mark.parametrize("convention", Convention)
@pytest.mark.parametrize("name", SYSTEMS)
def test_every_frame_and_link_of_every_system_is_drawn(name, convention):
    for braille in (True, False):
        drawn = pictures(name, convention, braille=braille)
        assert all(AXIS_WORD in picture for picture in drawn.values())


def test_frames_at_one_place_have_their_names_side_by_side():
    wrist = [JointAxis((0, 0, 0), direction) for direction in ((0, 0, 1), (0, 1, 0), (0, 0, 1))]
    found = assign_frames(wrist, tip_frame(wrist[-1], (0, 0, 0)))
    picture = StepDrawing(found).rows(3, 78, 24, linked=True, braille=False)
    assert "L0 L1 L2 L3 b1 b2 b3" in "\n".join(picture)
