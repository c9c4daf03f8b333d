"""Drawings in space: all on their canvas, the kept backdrop as a fresh one, inks look unlike."""

import re

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from space_cases import (
    CAMERAS,
    PLANNED,
    SIZES,
    driven,
    guarded,
    picture,
    picture_file,
    six_axes,
)

from armdrive.render.camera import VIEWS
from armdrive.render.canvas import PATTERNS, Ink, Layer, Letters, Raster, Stroke
from armdrive.render.frame_steps import AXIS_WORD, StepDrawing
from armdrive.render.scene import ArmDrawing, Moment, SceneSpace, Studio
from kinematics import Joints
from kinematics.chains.assignment import assign_frames, zero_position
from kinematics.chains.links import Convention
from kinematics.guards.shapes import Box
from kinematics.textbook.systems import system
from kinematics.textbook.thirteen_steps import assignment_steps

INKS = st.sampled_from(sorted(PATTERNS))
POINTS = st.tuples(*(st.floats(-2000.0, 2000.0) for _ in "xyz"))
LAYERS = st.builds(
    Layer,
    st.lists(st.builds(Stroke, INKS, st.lists(POINTS, max_size=4).map(tuple)), max_size=4).map(
        tuple
    ),
    st.lists(st.builds(Letters, INKS, POINTS, st.text(max_size=6)), max_size=3).map(tuple),
    st.lists(POINTS, max_size=3).map(tuple),
)
SPACES = st.builds(
    SceneSpace,
    LAYERS,
    st.lists(LAYERS, max_size=4).map(tuple),
    st.sampled_from(("", "reach at pitch 5")),
    st.text(max_size=9),
)
DOME = ArmDrawing(guarded()).dome


@given(SPACES, CAMERAS, SIZES, st.booleans())
def test_each_kind_of_line_is_drawn_in_its_own_characters(space, camera, size, braille):
    painted = Studio(DOME, braille=braille).draw(space, camera, *size)
    rows = painted.rows()
    assert [len(row) for row in rows] == [size[0]] * size[1]
    for y, row in enumerate(rows):
        assert "".join(text for text, _ in painted.runs(y)) == row
    for letter in "".join(rows):
        assert " " <= letter <= "~" or (braille and "\u2800" < letter <= "\u28ff")


@given(st.lists(st.tuples(SPACES, st.booleans()), min_size=1, max_size=4), st.booleans())
def test_a_kept_backdrop_shows_what_a_fresh_drawing_shows(shown, braille):
    kept = Studio(DOME, braille=braille)
    for space, from_above in (*shown, *shown):
        camera = VIEWS["top" if from_above else "iso"]
        fresh = Studio(DOME, braille=braille).draw(space, camera, 40, 20)
        assert kept.draw(space, camera, 40, 20) == fresh


@given(SPACES, SPACES, SIZES, st.booleans())
def test_painting_the_changed_spans_over_the_old_picture_gives_the_new_one(old, new, size, braille):
    studio = Studio(DOME, braille=braille)
    before = studio.draw(old, VIEWS["iso"], *size)
    after = studio.draw(new, VIEWS["side"], *size)
    screen = cells(before)
    target = cells(after)
    for x, y, width in after.changes(before):
        assert width > 0
        screen[y][x : x + width] = target[y][x : x + width]
    assert screen == target
    assert list(after.changes(after)) == []


def cells(painted):
    """Characters with their inks, where an empty cell has none that could be seen."""
    return [
        [
            (letter, ink if letter != " " else 0)
            for letter, ink in zip(painted.row(y), painted.inks_of(y), strict=True)
        ]
        for y in range(painted.height)
    ]


def test_the_spans_of_a_picture_in_which_nothing_moved_but_the_arm_are_few():
    scene = driven(guarded())
    studio = Studio(scene.dome, braille=True)
    one, two = (
        studio.draw(
            scene.space(Moment(Joints.of(20.0 + by, 60.0, -80.0, -60.0, 0.0))),
            VIEWS["iso"],
            100,
            34,
        )
        for by in (0.0, 0.4)
    )
    spans = list(two.changes(one))
    assert 0 < sum(width for *_, width in spans) < 100 * 34 / 20
    assert len(spans) == len({y for _, y, _ in spans})  # what is close together is one


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("braille", [True, False])
def test_the_pictures_are_those_that_somebody_looked_at(view, braille):
    kept = picture_file(view, braille=braille).read_text(encoding="utf-8").splitlines()
    assert [row.rstrip() for row in picture(view, braille=braille)] == kept


def test_no_two_inks_that_run_in_lines_look_alike():
    """Solid ones differ by place and thickness, and axes by their letters."""
    dashed = [PATTERNS[ink] for ink in PATTERNS if PATTERNS[ink].period > 1]
    assert len({(one.on, one.period) for one in dashed}) == len(dashed)
    marks = [one.mark for one in PATTERNS.values() if one.mark]
    assert len(set(marks)) == len(marks)


@every_row("ink", [ink for ink in PATTERNS if PATTERNS[ink].period > 1])
def test_a_dashed_line_has_its_gaps_over_corners_too(ink):
    drawn = Raster(60, 1, braille=True)
    drawn.line([(x, 0.0) for x in range(0, 120, 3)], ink)
    pattern = PATTERNS[ink]
    cells = [0 if cell == " " else ord(cell) for cell in drawn.painted().text]
    bits = [cells[x // 2] >> (0 if x % 2 == 0 else 3) & 1 for x in range(118)]
    assert bits == [int(x % pattern.period < pattern.on) for x in range(118)]


@pytest.mark.parametrize("model", [guarded(), six_axes()])
def test_the_arm_its_ghost_its_way_and_its_axes_are_all_there(model):
    scene = ArmDrawing(model)
    bent = tuple(0.6 * one.low_rad + 0.4 * one.high_rad for one in model.arm.limits)
    goal = Joints(tuple(angle + 0.3 for angle in bent), model.arm.joint_names)
    here = Joints(bent, model.arm.joint_names)
    moment = Moment(here, 30.0, goal=goal, planned=PLANNED)
    scene.space(moment)
    scene.keep(scene.missing, scene.work_out(scene.missing))
    studio = Studio(scene.dome, braille=True)
    painted = studio.draw(scene.space(moment), VIEWS["iso"], 120, 40)
    wanted = {Ink.TABLE, Ink.REACH, Ink.BASE, Ink.PLANNED, Ink.GOAL, Ink.ARM, Ink.JOINT, Ink.AXIS}
    assert wanted <= {Ink(ink) for ink in painted.inks}
    nearer = VIEWS["iso"].zoomed(7, scene.tip, scene.dome)
    assert Ink.GRIPPER in set(studio.draw(scene.space(moment), nearer, 120, 40).inks)
    assert {"x", "y", "z", "G"} <= set("".join(painted.rows()[1:-1]))
    assert "goal G" in painted.rows()[-1]
    assert "reach at" in painted.rows()[-1]


def test_an_unknown_posture_is_said_and_not_drawn():
    scene = driven(guarded())
    painted = Studio(scene.dome, braille=True).draw(
        scene.space(Moment(), "posture not known"), VIEWS["iso"], 60, 24
    )
    assert any("posture not known" in row for row in painted.rows())
    assert not {Ink.ARM, Ink.AXIS, Ink.JOINT} & {Ink(ink) for ink in painted.inks}


def test_the_name_of_a_box_can_send_nothing_to_the_terminal():
    box = Box("\x1b[2J\u202e\xe4", (200.0, -150.0, 0.0), (320.0, -60.0, 60.0))
    scene = ArmDrawing(guarded(boxes=(box,)))
    painted = Studio(scene.dome, braille=False).draw(scene.space(Moment()), VIEWS["top"], 80, 30)
    assert any("?[2J??" in row for row in painted.rows())


# The pictures of a frame assignment: what each frame and link adds, and nothing more.


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
@pytest.mark.parametrize("name", ["two-link-5", "puma"])
def test_every_frame_and_link_is_drawn(name, convention):
    for braille in (True, False):
        drawn = pictures(name, convention, braille=braille)
        assert all(AXIS_WORD in picture for picture in drawn.values())
