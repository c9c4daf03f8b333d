"""A model jogged with no arm: every key, what is shown beside it, and how little can go wrong."""

import math

import pytest
from amounts import every_row
from desk_planner import at_rest
from desk_session import AppSession

from armdrive.cli.learn.models import find_subject
from kinematics.textbook.systems import MODEL_NAMES
from kinematics.textbook.worked_example import sections
from tui.keys.keyboard import keyboard_of
from tui.keys.layouts import LAYOUTS
from tui.keys.table import TABLE, pairs_of
from tui.model_desk import MODEL, NO_ARM, ModelDesk, ModelHand, model_keys
from tui.widgets import PlainText


class Session(AppSession):
    """A model's desk on a headless terminal."""

    def __init__(self, name="two-link-1", *, size=(80, 24), **more):
        self.desk = ModelDesk(find_subject(name), braille=True, **more)
        super().__init__(self.desk, size=size)

    async def __aenter__(self):
        await super().__aenter__()
        await at_rest(self.pilot)  # the first look at the model lays the screen out again
        return self

    @property
    def degrees(self):
        return [round(math.degrees(value), 6) for value in self.desk.hand.values]


async def test_the_screen_says_that_there_is_no_arm_and_a_stop_key_only_closes_the_help():
    async with Session() as session:
        assert session.text("title").startswith(NO_ARM)
        assert "Links" in session.text("example")
        assert "manipulability" in session.text("model-summary")
        assert session.text("joints").startswith(" q  a   theta1")
        everything = " ".join(each.shown for each in session.desk.screen.query(PlainText))
        assert "STOP" not in everything
        assert "trust" not in everything
        await session.press("left_square_bracket", "left_square_bracket", "right_square_bracket")
        assert "one step is 2° or 2 mm" in session.text("messages")
        for key in ("space", "escape"):
            await session.press("question_mark")
            assert len(session.desk.screen_stack) == 2
            await session.press(key)
            assert len(session.desk.screen_stack) == 1
            assert "nothing to stop" in session.text("messages")
        await session.press("ctrl+q")
    assert session.desk.return_value == 0


STEP = math.radians(5)
JOGS = {
    # a model, and by how much each key moves which joint
    "two-link-1": [("q", 0, STEP), ("a", 0, -STEP), ("w", 1, STEP), ("s", 1, -STEP),
                   ("left", 0, STEP), ("down", 1, -STEP)],
    "two-link-3": [("w", 1, 5.0)],
    "puma": [("y", 5, STEP)],
}  # fmt: skip


@every_row("name", JOGS)
def test_a_jog_key_moves_its_joint_by_one_increment(name):
    hand = ModelHand(find_subject(name))
    for key, joint, by in JOGS[name]:
        before = hand.values
        assert not hand.press(key)
        moved = [b - a for a, b in zip(before, hand.values, strict=True)]
        assert moved == pytest.approx([by if i == joint else 0.0 for i in range(len(moved))]), key


async def test_a_key_or_a_click_on_its_cap_is_one_step():
    async with Session() as session:
        await session.press("a")
        before = session.desk.hand.values
        await session.pilot.mouse_down("#joints", offset=(5, 1))
        await session.pilot.mouse_up("#joints", offset=(5, 1))
        assert session.desk.hand.values[0] == pytest.approx(before[0] - STEP)
        assert session.desk.hand.values[1:] == before[1:]
        await session.press("q", "q")
        assert session.desk.hand.values[0] == pytest.approx(before[0] + STEP)


async def test_the_matrices_follow_the_joints_at_once():
    async with Session() as session:
        await session.press("Z")
        assert "[ 1  0  0  200 ]" in session.text("example")
        assert "condition number infinite; singular 0.0°" in session.text("model-summary")
        await session.press(*["q"] * 6)
        assert "[ 0.866   -0.5  0  173.21 ]" in session.text("example")


async def test_the_hand_is_jogged_by_the_same_keys_in_the_other_mode():
    async with Session() as session:
        x, y = session.desk.hand.study.goal
        await session.press("m", "q")
        await at_rest(session.pilot)
        assert session.desk.hand.study.goal == pytest.approx((x + 5.0, y))
        assert "keys move the hand" in session.text("messages")
        assert session.text("hand").startswith(" q  a   x ")
        assert not session.desk.screen.query_one("#joints").display, "there is no room for both"
        await session.press("e")
        assert "this model has no axis for that key" in session.text("messages")
        await session.press("right_square_bracket", "right_square_bracket", *["q"] * 10)
        assert "out of reach" in session.text("messages")


def test_the_next_solution_is_the_same_place_of_the_hand():
    hand = ModelHand(find_subject("two-link-1"))
    before, elbow = hand.study.goal, hand.values[1]
    assert "the same pose of the hand by elbow up" in hand.next_solution()
    assert hand.values[1] < 0 < elbow
    assert hand.study.goal == pytest.approx(before)
    hand.next_solution()
    assert hand.values[1] == pytest.approx(elbow)


async def test_the_worked_example_is_scrolled_to_its_end_and_no_line_of_it_is_cut():
    async with Session("puma") as session:
        example = session.desk.screen.query_one("#model-right")
        titles = [part.title for part in sections(session.desk.hand.study)]
        assert {"Jacobian", "Singularities", "Inverse kinematics"} <= set(titles)
        assert all(title in session.text("example") for title in titles if title != "Figure")
        assert example.max_scroll_y > 0
        for key, ends_at in (("pagedown", example.max_scroll_y), ("pageup", 0)):
            await session.press(*[key] * 30)
            assert example.scroll_y == ends_at, key


@every_row("name", MODEL_NAMES)
def test_no_row_of_a_matrix_is_too_wide_for_its_column(name):
    for part in sections(ModelHand(find_subject(name)).study):
        assert not [line for line in part.lines if "[ " in line and len(line) > 44], part.title


def test_the_help_names_every_key_of_a_model_and_no_other():
    keys = model_keys()
    pairs = pairs_of(("theta1", "theta2"), ("x", "y", "z"))
    listed = "\n".join(keys.help(MODEL, pairs))
    offered = [row.id for row in keys.next_keys(MODEL)]
    for row in TABLE:
        if row.counts_at(MODEL) and not row.jogs:
            assert row.tooltip in listed
    assert "e d               (Cartesian mode: z)" in listed
    assert "reference" not in listed
    assert "reset" not in offered
    assert "model-solution" in offered


@every_row("layout", LAYOUTS)
def test_no_key_of_a_model_does_two_things_on_any_layout(layout):
    rows = model_keys(keyboard_of(layout)).rows
    keys = [key for row in rows if not row.counts_at("dialog") for key in row.all_keys]
    assert len(keys) == len(set(keys))


def test_a_model_in_plain_ascii(snap_compare):
    desk = ModelDesk(find_subject("spherical"), braille=False)
    assert snap_compare(desk, press=["m", "e"], terminal_size=(80, 24))
