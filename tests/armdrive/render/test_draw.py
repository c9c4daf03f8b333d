"""Lines, clipping, postures as rows of characters, and the choice of characters."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.render.camera import VIEWS
from armdrive.render.canvas import Ink, can_braille, clip, raster
from armdrive.render.scene import Moment, PostureDrawing, posture_cameras
from kinematics import Joints, preset
from kinematics.guards.shapes import Box

MODEL = preset("teachmover")


def posture(base_deg=0.0, links_deg=(60.0, -80.0, -60.0)):
    return Joints.of(base_deg, *links_deg, 0.0)


def drawn(joints, view, size=(60, 20), *, braille=True, opening_mm=30.0, blocks=()):
    drawing = PostureDrawing(MODEL, braille=braille)
    draw = (drawing.side, drawing.top)[view]
    return draw(Moment(joints, opening_mm), *size, blocks)


SIDE, TOP = 0, 1


def marks(rows):
    """Cells that are not blank, as (column, row)."""
    return {(x, y) for y, row in enumerate(rows) for x, cell in enumerate(row) if cell != " "}


def lines(width, height, *points, braille, ink=Ink.BASE):
    """Draw a line through points, given in dots, on an empty raster."""
    canvas = raster(width, height, braille=braille)
    canvas.line(points, ink)
    return canvas.painted().rows()


@pytest.mark.parametrize(
    ("size", "points", "braille", "rows"),
    [
        pytest.param((3, 1), [(0, 0), (5, 0)], True, ["⠉⠉⠉"], id="upper dots of braille cells"),
        pytest.param(
            (1, 1), [(0, 0), (0, 3), (1, 3), (1, 0)], True, ["⣿"], id="a full braille cell"
        ),
        pytest.param((0, 0), [(0, 0), (5, 5)], True, [], id="an empty canvas"),
    ],
)
def test_a_small_picture(size, points, braille, rows):
    assert lines(*size, *points, braille=braille) == rows


@pytest.mark.parametrize(("above", "below"), [(Ink.BASE, Ink.TABLE), (Ink.JOINT, Ink.ARM)])
@pytest.mark.parametrize("flipped", [False, True])
def test_the_greater_ink_is_seen_whichever_was_drawn_first(above, below, flipped):
    canvas = raster(3, 1, braille=False)
    for ink in (below, above) if flipped else (above, below):
        canvas.line([(0, 0), (2, 0)], ink)
    assert canvas.painted().inks == bytes([above] * 3)


@pytest.mark.parametrize(
    ("column", "row", "text", "shown"),
    [(-1, 0, "abc", "bc  "), (3, 0, "xyz", "   x"), (0, 1, "below", "    "), (0, -1, "up", "    ")],
)
def test_text_is_clipped_at_every_edge(column, row, text, shown):
    canvas = raster(4, 1, braille=True)
    canvas.text(column, row, text, Ink.WORD)
    assert canvas.painted().rows() == [shown]


@pytest.mark.parametrize(
    ("end", "stroke"), [((4, 0), "-"), ((0, 4), "|"), ((4, 4), "\\"), ((4, -4), "/")]
)
def test_ascii_lines_take_the_stroke_of_their_slope(end, stroke):
    down = 0 if end[1] >= 0 else 4
    rows = lines(5, 5, (0, down), (end[0], down + end[1]), braille=False)
    assert {rows[y][x] for x, y in marks(rows)} == {stroke}


anywhere = st.floats(-1e6, 1e6)


@given(anywhere, anywhere, anywhere, anywhere, st.booleans())
def test_any_line_leaves_a_picture_of_the_right_size(x0, y0, x1, y1, braille):
    assert [len(row) for row in lines(7, 3, (x0, y0), (x1, y1), braille=braille)] == [7, 7, 7]


@given(st.integers(0, 13), st.integers(0, 11), st.integers(0, 13), st.integers(0, 11))
def test_a_line_is_drawn_at_its_ends_from_either_side(x0, y0, x1, y1):
    for start, end in (((x0, y0), (x1, y1)), ((x1, y1), (x0, y0))):
        cells = marks(lines(7, 3, start, end, braille=True))
        assert {(x0 // 2, y0 // 4), (x1 // 2, y1 // 4)} <= cells


@given(st.floats(-300, 300), st.floats(-300, 300))
def test_every_dot_of_a_clipped_line_lies_on_the_whole_one(x, y):
    dots = marks(lines(40, 20, (20, 10), (x, y), braille=False))
    dx, dy = x - 20, y - 10
    length = math.hypot(dx, dy)
    assert dots
    for column, row in dots:
        off = abs((column - 20) * dy - (row - 10) * dx) / length if length > 1 else 0.0
        assert off <= 1.0


@given(anywhere, anywhere, anywhere, anywhere)
def test_a_clipped_line_ends_on_the_canvas(x0, y0, x1, y1):
    kept = clip((x0, y0, x1, y1), 30.0, 20.0)
    assert kept is None or all(
        0.0 <= value <= edge for value, edge in zip(kept, (30, 20) * 2, strict=True)
    )


# Postures, as a question shows them.


@pytest.mark.parametrize("view", [SIDE, TOP])
@pytest.mark.parametrize("braille", [True, False])
@pytest.mark.parametrize("size", [(0, 0), (1, 1), (38, 11), (120, 40), (10, 60)])
def test_a_view_fills_exactly_the_cells_it_was_given(view, braille, size):
    rows = drawn(posture(), view, size, braille=braille)
    assert [len(row) for row in rows] == [size[0]] * size[1]
    assert braille or "".join(rows).isascii()


def test_the_side_view_is_the_arms_own_plane_whatever_the_base():
    """The letters of the table's axes alone go round."""
    straight, turned, lower = (
        drawn(joints, SIDE)[:17]  # without table and legend
        for joints in (posture(), posture(70.0), posture(links_deg=(20.0, -80.0, -60.0)))
    )
    assert straight == turned
    assert straight != lower


def test_turning_the_base_left_moves_the_drawing_left():
    middle = {}
    for base_deg in (60.0, -60.0):
        rows = drawn(posture(base_deg), TOP, (61, 20), braille=False)[1:-1]  # without words
        middle[base_deg] = [x for x, y in marks(rows) if rows[y][x] in "o/\\"]
    assert sum(middle[60.0]) / len(middle[60.0]) < 30 < sum(middle[-60.0]) / len(middle[-60.0])


def test_both_axes_have_one_scale():
    """A square block is as many dots wide as it is high, with ASCII dots twice as tall."""
    block = Box(" ", (-100.0, -100.0, 400.0), (100.0, 100.0, 600.0))
    bare, blocked = (
        drawn(posture(), SIDE, (100, 40), braille=False, blocks=blocks) for blocks in ([], [block])
    )
    cells = [(x, y) for x, y in marks(blocked) if blocked[y][x] != bare[y][x]]
    wide, high = (max(axis) - min(axis) for axis in zip(*cells, strict=True))
    assert wide == pytest.approx(2 * high, abs=2)


def test_opening_the_gripper_changes_the_fingers():
    assert drawn(posture(), TOP, opening_mm=0.0) != drawn(posture(), TOP, opening_mm=76.0)


def test_blocks_carry_their_names():
    block = Box("red", (220.0, -30.0, 0.0), (280.0, 30.0, 60.0))
    assert any("red" in row for row in drawn(posture(), SIDE, braille=False, blocks=[block]))


def test_a_drawing_shows_one_posture_alone():
    """No trail of the postures before, which another drawing has never seen."""
    drawing, there = PostureDrawing(MODEL, braille=True), Moment(posture(30.0), 30.0)
    for base_deg in range(0, 30, 2):
        drawing.top(Moment(posture(float(base_deg)), 30.0), 60, 20)
    assert drawing.top(there, 60, 20) == PostureDrawing(MODEL, braille=True).top(there, 60, 20)


def test_an_unknown_posture_is_seen_from_the_usual_side():
    assert posture_cameras(None) == (VIEWS["side"], VIEWS["top"])


@given(st.floats(-180, 180), st.tuples(*(st.floats(-180, 180) for _ in "seh")), st.floats(0, 76))
def test_every_posture_can_be_drawn(base_deg, links_deg, opening_mm):
    for view in (SIDE, TOP):
        joints = posture(base_deg, links_deg)
        assert len(marks(drawn(joints, view, (30, 10), opening_mm=opening_mm))) > 10


@pytest.mark.parametrize(
    ("encoding", "environ", "legible"),
    [
        ("utf-8", {"LANG": "en_GB.UTF-8", "TERM": "xterm-256color"}, True),
        ("UTF8", {}, True),
        ("utf-8", {"LANG": "C", "LC_ALL": "C.utf8"}, True),
        ("utf-8", {"LANG": "de_DE.UTF-8@euro"}, True),
        ("utf-8", {"LANG": "C.UTF-8", "TERM": "linux"}, False),
        ("utf-8", {"LANG": "C.UTF-8", "TERM": "dumb"}, False),
        ("utf-8", {"LANG": "en_US.UTF-8", "LC_ALL": "POSIX"}, False),
        ("cp1252", {}, False),
        ("ascii", {"LANG": "en_GB.UTF-8"}, False),
        (None, {"LANG": "en_GB.UTF-8"}, False),
    ],
)
def test_braille_only_where_it_is_legible(encoding, environ, legible):
    assert can_braille(encoding, environ) is legible
