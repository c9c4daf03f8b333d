"""What the desk says is about the screen that is shown, whole, and asks what is meant."""

import re

import pytest
from desk_fake import FakeArm, unknown_position
from desk_planner import PlannerArm, settled
from desk_session import Session

from armdrive.connecting import simulated_config
from armdrive.draw.camera import VIEWS
from armdrive.draw.scene import Moment, Scene
from armdrive.draw.studio import Studio
from kinematics import Joints
from tui.framework import PlainText
from tui.keyboard import KEYS_WIDTH
from tui.screens import SCREENS
from tui.widgets.theory_panel import TheoryPanel


class SwitchedArm(FakeArm):
    """Homes by its own switches."""

    homes_by_switches = True


class PlainArm(PlannerArm):
    """Has the abilities that every screen asks for but the log's."""

    config = simulated_config("teachmover")


async def test_what_was_said_on_one_screen_is_not_said_on_the_next():
    async with Session(PlainArm()) as session:
        session.desk.say("that pose is out of reach")
        await session.press("f4")
        await settled(session.pilot)
        assert "out of reach" not in session.text("remarks")


async def test_a_jog_that_a_change_of_screen_has_ended_is_said_on_the_next():
    async with Session(PlainArm()) as session:
        await session.arm_keys()
        await session.press("f4")
        await settled(session.pilot)
        assert "keys disarmed: another screen is shown" in session.text("remarks")


@pytest.mark.parametrize("entry", SCREENS[:5], ids=lambda entry: entry.id)
async def test_each_screen_begins_with_a_word_about_itself(entry):
    async with Session(PlainArm()) as session:
        await session.press(entry.key)
        await settled(session.pilot)
        remarks = session.text("remarks")
        assert ("arms the jog keys" in remarks) == (entry.id == "jog")
        if entry.id != "jog":
            assert remarks == f"! {entry.title}: {entry.summary}"
        session.desk.say("something else")
        assert session.text("remarks") == "! something else"


@pytest.mark.parametrize(
    ("arm", "key", "asked"),
    [
        (SwitchedArm(), "H", "Is its way clear?"),
        (FakeArm(), "P", "Is it supported?"),
        (FakeArm(simulated=False, **unknown_position()), "H", "Does the arm stand exactly so?"),
    ],
)
async def test_one_question_is_asked_and_it_is_the_one_that_is_meant(arm, key, asked):
    async with Session(arm) as session:
        await session.press(key)
        await session.pilot.pause()
        texts = [each.shown for each in session.desk.screen.query(PlainText)]
        assert re.findall(r"[^.:\n]*\?", "\n".join(texts)) == [asked]


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
async def test_lines_of_the_help_go_on_under_their_words(size):
    async with Session(size=size) as session:
        await session.press("question_mark")
        await session.pilot.pause()
        text = session.desk.screen.query_one("#help-text", PlainText)
        lines = text.shown.splitlines()
        assert max(map(len, lines)) <= text.content_size.width
        assert any(line.startswith(" " * KEYS_WIDTH) for line in lines)
        whole = re.sub(r"\s+", " ", text.shown)
        assert "Space is 0.1 s quicker than Esc. ? f1 Show all keys." in whole


@pytest.mark.parametrize("size", [(80, 24), (120, 40), (200, 60)])
async def test_what_is_said_of_singularities_is_not_cut_where_there_is_room(size):
    async with Session(size=size) as session:
        await session.press("f6")
        await settled(session.pilot)
        panel = session.desk.place.query_one(TheoryPanel)
        summary = panel.query_one("#theory-summary", PlainText)
        needed = summary.visual.get_height(summary.styles, summary.content_size.width)
        assert summary.content_size.height == min(needed, panel.size.height // 5)
        if size != (80, 24):
            assert summary.content_size.height == needed


def test_the_legend_of_the_desk_at_120_columns_names_the_goal():
    model = simulated_config("teachmover").model
    here, there = (Joints.of(base, 50.0, -100.0, -10.0, 0.0) for base in (20.0, -20.0))
    way = tuple((200.0, y_mm, 100.0) for y_mm in (90.0, 0.0, -90.0))
    scene = Scene(model)
    moment = Moment(here, 40.0, goal=there, planned=way)
    scene.space(moment)
    scene.keep(scene.missing, scene.work_out(scene.missing))
    drawn = Studio(scene.dome, braille=True).draw(scene.space(moment), VIEWS["iso"], 60, 30)
    legend = list(drawn.rows())[-1]
    for word in ("reach at pitch", "guard", "way", "goal G"):
        assert word in legend
