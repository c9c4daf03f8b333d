"""Lines, views and the choice of characters."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.render.canvas import Canvas, can_braille
from armdrive.render.side_view import ArmScene, DrawnBox, side_view, top_view

REACH_MM = 452.0


def posture(*, base_deg=0.0, links_deg=(60.0, -20.0, -80.0)):
    """Points of an arm whose links stand at these elevations."""
    base = math.radians(base_deg)
    r, z = 0.0, 195.0
    points = [(0.0, 0.0, 0.0), (0.0, 0.0, z)]
    for length, elevation in zip((177.8, 177.8, 96.5), links_deg, strict=True):
        r += length * math.cos(math.radians(elevation))
        z += length * math.sin(math.radians(elevation))
        points.append((r * math.cos(base), r * math.sin(base), z))
    return tuple(points)


def scene(base_deg=0.0, opening_mm=30.0, **more):
    return ArmScene(
        posture(base_deg=base_deg), opening_mm, math.radians(base_deg), REACH_MM, **more
    )


def ink(rows):
    """Cells that are not blank, as (column, row)."""
    return {(x, y) for y, row in enumerate(rows) for x, cell in enumerate(row) if cell != " "}


def drawn(width, height, braille, *calls):
    """Call the methods of an empty canvas, and return its rows."""
    canvas = Canvas(width, height, braille=braille)
    for method, *values in calls:
        options = values.pop() if isinstance(values[-1], dict) else {}
        getattr(canvas, method)(*values, **options)
    return canvas.rows()


SMALL_PICTURES = {
    "a line along the top fills the upper dots of every braille cell": (
        (3, 1, True), [("line", 0, 0, 5, 0)], ["⠉⠉⠉"],
    ),
    "a full braille cell has all eight dots": (
        (1, 1, True), [("line", 0, row, 1, row) for row in range(4)], ["⣿"],
    ),
    "crossing ASCII lines meet in a plus": (
        (3, 3, False), [("line", 0, 1, 2, 1), ("line", 1, 0, 1, 2)], [" | ", "-+-", " | "],
    ),
    "a faint mark gives way to a stroke drawn later": (
        (3, 1, False), [("line", 0, 0, 2, 0, {"stroke": "."}), ("line", 0, 0, 2, 0)], ["---"],
    ),
    "a faint mark gives way to a stroke that is there": (
        (3, 1, False), [("line", 0, 0, 2, 0), ("line", 0, 0, 2, 0, {"stroke": "."})], ["---"],
    ),
    "a marked joint is not crossed out by a line": (
        (3, 1, False), [("dot", 1, 0, "o"), ("line", 0, 0, 2, 0)], ["-o-"],
    ),
    "text is clipped at every edge": (
        (4, 1, True),
        [("text", -1, 0, "abc"), ("text", 3, 0, "xyz"), ("text", 0, 1, "below"),
         ("text", 0, -1, "above")],
        ["bc x"],
    ),
    "a sparse line leaves dots out": (
        (6, 1, False), [("line", 0, 0, 5, 0, {"every": 3})], ["-  -  "],
    ),
    "nothing is drawn on an empty canvas": (
        (0, 0, True), [("line", 0, 0, 5, 5), ("dot", 0, 0)], [],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("size", "calls", "rows"), SMALL_PICTURES.values(), ids=SMALL_PICTURES)
def test_a_small_picture(size, calls, rows):
    assert drawn(*size, *calls) == rows


@pytest.mark.parametrize(
    ("end", "stroke"), [((4, 0), "-"), ((0, 4), "|"), ((4, 4), "\\"), ((4, -4), "/")]
)
def test_ascii_lines_take_the_stroke_of_their_slope(end, stroke):
    canvas = Canvas(5, 5, braille=False)
    down = 0 if end[1] >= 0 else 4
    canvas.line(0, down, end[0], down + end[1])
    assert {canvas.rows()[y][x] for x, y in ink(canvas.rows())} == {stroke}


anywhere = st.floats(-1e6, 1e6)


@given(anywhere, anywhere, anywhere, anywhere, st.booleans())
def test_any_line_leaves_a_picture_of_the_right_size(x0, y0, x1, y1, braille):
    canvas = Canvas(7, 3, braille=braille)
    canvas.line(x0, y0, x1, y1)
    assert [len(row) for row in canvas.rows()] == [7, 7, 7]


@given(st.integers(0, 13), st.integers(0, 11), st.integers(0, 13), st.integers(0, 11))
def test_a_line_is_the_same_from_either_end_at_its_ends(x0, y0, x1, y1):
    for start, end in (((x0, y0), (x1, y1)), ((x1, y1), (x0, y0))):
        canvas = Canvas(7, 3, braille=True)
        canvas.line(*start, *end)
        cells = ink(canvas.rows())
        assert (x0 // 2, y0 // 4) in cells
        assert (x1 // 2, y1 // 4) in cells


@given(st.floats(-300, 300), st.floats(-300, 300))
def test_every_dot_of_a_clipped_line_lies_on_the_whole_one(x, y):
    canvas = Canvas(40, 20, braille=False)
    canvas.line(20, 10, x, y)
    dots = ink(canvas.rows())
    dx, dy = x - 20, y - 10
    length = math.hypot(dx, dy)
    assert dots
    for column, row in dots:
        off = abs((column - 20) * dy - (row - 10) * dx) / length if length > 1 else 0.0
        assert off <= 1.0


@pytest.mark.parametrize("view", [side_view, top_view])
@pytest.mark.parametrize("braille", [True, False])
@pytest.mark.parametrize("size", [(0, 0), (1, 1), (38, 11), (120, 40), (10, 60)])
def test_a_view_fills_exactly_the_cells_it_was_given(view, braille, size):
    rows = view(scene(), *size, braille)
    assert [len(row) for row in rows] == [size[0]] * size[1]


def test_ascii_views_hold_nothing_but_ascii():
    assert "".join(side_view(scene(), 60, 20, False) + top_view(scene(), 60, 20, False)).isascii()


def test_the_side_view_is_the_arms_own_plane_whatever_the_base():
    assert side_view(scene(0.0), 60, 20, True) == side_view(scene(70.0), 60, 20, True)


def test_turning_the_base_left_moves_the_drawing_left():
    arm_only = {}
    for base_deg in (60.0, -60.0):
        rows = top_view(scene(base_deg), 61, 20, False)
        arm_only[base_deg] = [x for x, y in ink(rows) if rows[y][x] in "o/\\"]
    assert sum(arm_only[60.0]) / len(arm_only[60.0]) < 30
    assert sum(arm_only[-60.0]) / len(arm_only[-60.0]) > 30


def test_both_axes_have_one_scale():
    """A square block is as many dots wide as it is high, with ASCII dots twice as tall."""
    block = DrawnBox("", 0.0, 0.0, 400.0, 200.0, 200.0)
    far = ArmScene(((0.0, 0.0, 0.0), (0.0, 0.0, 195.0)), 0.0, 0.0, REACH_MM, (block,))
    rows = side_view(far, 100, 40, False)
    cells = [(x, y) for x, y in ink(rows) if rows[y][x] == "#"]
    wide = max(x for x, _ in cells) - min(x for x, _ in cells)
    high = max(y for _, y in cells) - min(y for _, y in cells)
    assert wide == pytest.approx(2 * high, abs=2)


def test_opening_the_gripper_changes_the_fork():
    assert side_view(scene(opening_mm=0.0), 60, 20, True) != side_view(
        scene(opening_mm=76.0), 60, 20, True
    )


def test_blocks_carry_their_initial_and_the_goal_its_cross():
    rows = side_view(
        scene(blocks=(DrawnBox("red", 250.0, 0.0, 0.0, 60.0, 60.0),), goal=(-200.0, 0.0, 100.0)),
        60,
        20,
        False,
    )
    assert any("r" in row for row in rows)
    assert any("X" in row for row in rows)


def test_range_lines_are_dotted():
    bare = top_view(scene(), 60, 20, True)
    bounded = top_view(scene(range_lines=(((0, 0, 0), (0, 400, 0)),)), 60, 20, True)
    assert len(ink(bounded)) > len(ink(bare))


@given(
    st.floats(-180, 180),
    st.tuples(st.floats(-180, 180), st.floats(-180, 180), st.floats(-180, 180)),
    st.floats(0, 76),
)
def test_every_posture_can_be_drawn(base_deg, links_deg, opening_mm):
    points = posture(base_deg=base_deg, links_deg=links_deg)
    drawn = ArmScene(points, opening_mm, math.radians(base_deg), REACH_MM)
    for view in (side_view, top_view):
        assert len(ink(view(drawn, 30, 10, True))) > 10


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
