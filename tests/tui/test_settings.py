"""Mode, increment and speed, and what a jog key means under them."""

import json

import pytest
from amounts import every_row
from desk_fake import FakeArm, busy_arm
from desk_planner import PlannerArm
from desk_session import Session

from armdrive.moves import Jog, Space
from tui.dialogs import first_facts
from tui.keys.keyboard import DEFAULT_KEYS
from tui.keys.table import JOG_PAIRS
from tui.settings import (
    INCREMENTS,
    LOOKS,
    SPEEDS,
    DeskMemory,
    DeskSettings,
    JogSettings,
    arm_key,
    recall,
    remember,
)


def test_increments_and_speeds_stop_at_the_ends_of_their_rows():
    settings = JogSettings()
    for by, end in ((99, -1), (-99, 0)):
        settings.change_speed(by)
        settings.change_step(by)
        settings.switch_mode()
        settings.change_step(by)
        settings.switch_mode()
        assert settings.speed == SPEEDS[end]
        assert settings.step_deg == settings.step_mm == INCREMENTS[end]


def test_a_tap_is_a_distance_and_a_hold_a_direction():
    settings = JogSettings(step_deg=5.0, frames=("base", "tool"))
    assert settings.increment_of("a") == Jog.joint(base=-5.0)
    assert settings.direction_of("a") == Jog.joint(base=-1.0)
    settings.switch_mode()
    assert settings.increment_of("up") == Jog(Space.CARTESIAN, (("z", 2.0),)), "mm by themselves"
    assert settings.increment_of("r") == Jog(Space.CARTESIAN, (("pitch", 5.0),))
    assert settings.increment_of("y") == Jog(Space.CARTESIAN, (("gripper", 2.0),))
    settings.next_frame()
    assert settings.increment_of("up") == Jog(Space.CARTESIAN, (("z", 2.0),), "tool")
    settings.switch_mode()
    assert settings.increment_of("up").frame == "base"  # a joint turns in no frame
    settings.next_frame()
    assert settings.frame == "base"


# What the desk remembers, its looks, its palette, and the first screen.


@pytest.fixture
def memory(tmp_path):
    """Return a file in which somebody has left the desk after reading the first screen."""
    path = tmp_path / "state" / "desk.json"
    remember(path, DeskMemory(instructed=True))
    return path


DAMAGED = (
    "",
    "{",
    "[]",
    "7",
    '{"speed": "fast", "look": 3, "instructed": "yes"}',
    "[" * 9000,
    '{"arms": 7, "look": 3}',
    '{"screen": "log", "speed": 1.0}',
    '{"instructed": 1, "layout": null}',
)


@every_row("text", DAMAGED, ids=lambda text: text[:40])
def test_a_damaged_memory_is_no_memory(tmp_path, text):
    path = tmp_path / "desk.json"
    path.write_text(text)
    assert recall(path) == DeskMemory()


SET = {
    "cartesian": True,
    "frame": "tool",
    "step_deg": 5.0,
    "step_mm": 0.5,
    "speed": 0.1,
    "move_cartesian": False,
    "move_speed": 0.25,
}
"""What was set on an arm, as it stands in the file."""

NONSENSE = ("sideways", "board", 3.3, 7, None, [1.0], {"speed": 1.0})


def settings_of(left, tmp_path):
    """Return the settings of a desk whose memory has this of its arm."""
    status = FakeArm().status
    path = tmp_path / "desk.json"
    remember(path, DeskMemory(arms={arm_key(status): left}))
    return path, DeskSettings(path, status, JOG_PAIRS, ("base", "tool"))


def test_what_does_not_exist_here_is_left_as_it_is(tmp_path):
    _, fresh = settings_of({}, tmp_path)
    for value in NONSENSE:
        _, found = settings_of(dict.fromkeys(SET, value), tmp_path)
        assert (found.jog, found.move) == (fresh.jog, fresh.move), value
    path, found = settings_of(SET, tmp_path)
    found.keep(FakeArm().status, "")
    assert recall(path).arms[arm_key(FakeArm().status)] == SET


async def test_a_desk_is_found_as_it_was_left_but_disarmed_and_without_a_goal(
    memory,
):
    async with Session(PlannerArm(), memory=memory) as session:
        await session.press("m", "F", "right_square_bracket", "minus", "T")
        await session.arm_keys()
        left = (session.text("stopping"), session.title("tip"))
        look = session.desk.look
        await session.press("f3", "m", "less_than_sign", "4", "0")
        form = session.screen.form
        assert (form.cartesian, form.settings.speed) == (False, 0.25)
        await session.press("ctrl+q")
    async with Session(PlannerArm(), memory=memory) as session:
        assert session.screen.place == "jog"
        assert (session.text("stopping"), session.title("tip")) == left
        assert session.desk.look == look
        assert not session.screen.armed
        await session.press("f3")
        form = session.screen.form
        assert (form.cartesian, form.settings.speed) == (False, 0.25)
        assert not any(form.field(name).text for name in form.names), (
            "a goal is not kept: whoever comes next has not seen it"
        )


async def test_the_first_screen_is_shown_until_somebody_has_read_it(tmp_path):
    path = tmp_path / "desk.json"
    async with Session(memory=path) as session:
        assert len(session.desk.screen_stack) == 2
        await session.press("q", "space")
        assert session.arm.calls == [("stop",)]
        await session.press("ctrl+q")
    assert json.loads(path.read_text())["instructed"] is False
    async with Session(memory=path) as session:
        await session.press("enter")
        assert len(session.desk.screen_stack) == 1
        assert not session.screen.armed, "one enter does not arm as well"
        await session.press("ctrl+q")
    assert json.loads(path.read_text())["instructed"] is True


def test_the_facts_are_three_lines_and_know_what_the_arm_feels():
    for dialect, feels in (("teachmover", "feels nothing"), ("mks", "feels only blocked motors")):
        facts = first_facts(DEFAULT_KEYS, FakeArm(dialect=dialect).status)
        assert len(facts) == 3
        assert max(map(len, facts)) <= 74
        assert feels in facts[1]
    assert "SPACE stops" in facts[0]
    assert "14 mm, 0.21 s" in facts[1]
    assert "reference (H)" in facts[2]


async def test_the_key_goes_round_all_looks():
    async with Session() as session:
        for theme, _ in (*LOOKS.values(), LOOKS["dark"]):
            assert session.desk.theme == theme
            await session.press("T")


@pytest.mark.parametrize(
    ("value", "theme", "said"),
    [("1", "ansi-dark", "NO_COLOR is set"), ("", "textual-light", "look: light")],
)
async def test_no_color_keeps_the_terminals_own_look_and_empty_counts_as_not_set(
    monkeypatch, value, theme, said
):
    monkeypatch.setenv("NO_COLOR", value)
    async with Session() as session:
        await session.follow([("T", {"messages": said})])
        assert session.desk.theme == theme


async def test_the_palette_opens_disarmed_and_does_what_is_chosen_and_a_space_stops():
    async with Session() as session:
        offered = list(session.desk.get_system_commands(session.desk.screen))
        for row in session.desk.keys.at("jog"):
            named = any(each.title.startswith(f"{row.description or row.id} (") for each in offered)
            listed = (row.description or row.also) and row.id != "palette"
            assert named == bool(listed and not row.jogs)
        await session.arm_keys()
        await session.press("ctrl+p")
        assert len(session.desk.screen_stack) == 2
        assert not session.screen.armed
        session.desk.close_dialogs()
        chosen = next(each for each in offered if each.title.startswith("mode ("))
        await chosen.callback()
        assert session.title("tip") == "Tip, Cartesian"
        await session.press("ctrl+p", *"mo")
        session.arm.calls.clear()
        await session.press("space")
        assert session.arm.calls == [("stop",)]
        assert len(session.desk.screen_stack) == 1


SPOKEN = {"home": "reference", "origin": "reference", "zero": "reference", "park": "park",
          "grip": "grasp", "estop": "e-stop", "emergency": "e-stop"}  # fmt: skip


async def test_the_palette_knows_the_words_that_people_use_and_does_rows_of_other_screens():
    async with Session(busy_arm(), first="log") as session:
        offered = [each.title for each in session.desk.get_system_commands(session.desk.screen)]
        for word, row in SPOKEN.items():
            assert any(word in title and title.startswith(f"{row} (") for title in offered), word
        await session.desk.action_do_row("grasp")
        assert session.screen.place == "jog"
        assert session.arm.asked("grasp") == [], "the keys are not armed"


def test_each_arm_has_settings_of_its_own_and_a_new_real_one_starts_slowly(memory):
    bench = {"arm": "bench", "simulated": False}
    visits = (
        # an arm, its jog speed, mode and move speed before, and the jog speed that is left
        ({}, (0.25, False, 0.5), 1.0),
        (bench, (0.1, False, 0.25), 0.25),
        ({**bench, "arm": "lab"}, (0.1, False, 0.25), 0.1),
        (bench, (0.25, True, 0.25), 0.25),
        ({}, (1.0, True, 0.5), 1.0),
    )
    for arm, before, left in visits:
        status = FakeArm(**arm).status
        settings = DeskSettings(memory, status, JOG_PAIRS, ("base",))
        assert (settings.jog.speed, settings.jog.cartesian, settings.move.speed) == before, arm
        settings.jog.speed, settings.jog.cartesian = left, True
        settings.keep(status, "")
