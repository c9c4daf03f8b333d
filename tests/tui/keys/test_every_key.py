"""Each key of the table is pressed where its row counts, and leads to the deed of that row."""

from contextlib import asynccontextmanager

import pytest
from desk_fake import END, MODEL, FakeArm, FakeHolder
from desk_logged import busy_arm
from desk_planner import CONFIG, PlannerArm
from desk_session import Session

from armdrive.status import State, status_view
from kinematics.textbook.study import named_subject
from tui.app import action_call
from tui.keys.keyboard import DEFAULT_KEYS
from tui.keys.table import SCREENS, TABLE
from tui.model_desk import ModelDesk, model_keys
from tui.watch import Watching

SCREEN_KEYS = {entry.id: entry.key for entry in SCREENS}
OPENED_BY = {
    "help": ("question_mark",),
    "question": ("H",),
    "line": ("f7", "enter"),
    "find": ("f7", "slash"),
    "catalogue": ("f7", "e"),
}
"""Dialogs, by the keys that lead to them."""


@asynccontextmanager
async def at_screen(name):
    arm = busy_arm() if name == "log" else PlannerArm()
    arm.config = CONFIG
    async with Session(arm) as session:
        await session.press(SCREEN_KEYS[name])
        await session.settle()
        yield session.desk, session.pilot, DEFAULT_KEYS.at(name)


@asynccontextmanager
async def at_dialog(name, memory):
    arm = busy_arm()
    arm.set(simulated=False)
    first = {"memory": memory / "none.json"} if name == "first" else {}
    async with Session(arm, **first) as session:
        for key in OPENED_BY.get(name, ()):
            await session.press(key)
            await session.settle()
        assert len(session.desk.screen_stack) == 2
        counting = tuple(row for row in TABLE if row.place == name or row.everywhere)
        yield session.desk, session.pilot, counting


@asynccontextmanager
async def running(app, rows):
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        yield app, pilot, rows


def place(name, memory):
    """Bring an app to a place; yields it, its pilot, and the rows that count there."""
    if name in SCREEN_KEYS:
        return at_screen(name)
    if name == "watch":
        app = Watching("sim", MODEL, FakeHolder(status_view(FakeArm().status), END), braille=True)
        return running(app, tuple(row for row in app.keys.rows if row.place in ("watch", "")))
    if name == "model":
        rows = tuple(row for row in model_keys().rows if row.place in ("theory", ""))
        return running(ModelDesk(named_subject("puma"), braille=True), rows)
    return at_dialog(name, memory)


def noting(app):
    """Have the app note every deed that a key leads to, and do none of them."""
    done = []

    async def note(action, default_namespace=None, namespaces=None):
        name = str(action).removeprefix("app.")
        holder = app if str(action).startswith("app.") else default_namespace or app
        assert action_call(name, holder), f"nothing does {action}"
        done.append(str(action).removeprefix("app."))
        return True

    app.run_action = note
    app.action_stop_arm = lambda: done.append("stop_arm")
    return done


DEEDS = {row.action for row in TABLE}
DIALOGS = ("first", *OPENED_BY)
PLACES = sorted({row.place for row in TABLE if row.place})


@pytest.mark.parametrize("name", PLACES)
async def test_every_key_of_the_table_leads_to_the_deed_of_its_row(name, tmp_path):
    """Of a dialog, all other keys lead to no deed; scrolling and the like are the framework's."""
    async with place(name, tmp_path) as (app, pilot, rows):
        done = noting(app)
        wanted = [(row.id, key, row.action) for row in rows for key in row.keys]
        assert wanted
        found = []
        for each, key, _ in wanted:
            done.clear()
            await pilot.press(key)
            found.append((each, key, " ".join(done)))
        assert found == wanted
        if name in DIALOGS:
            taken = {key for row in rows for key in row.keys}
            others = [key for row in TABLE for key in row.keys if key not in taken]
            assert others
            done.clear()
            for key in dict.fromkeys(others):
                await pilot.press(key)
            assert not DEEDS & set(done), "nothing of the screen goes through a dialog"


def test_every_row_of_the_table_counts_at_one_of_these_places():
    counted = {row.id for row in TABLE if not row.place} | {
        row.id for name in PLACES for row in DEFAULT_KEYS.at(name)
    }
    assert counted == {row.id for row in TABLE}


TYPED_INTO = [
    (PlannerArm, ["f3 2 5", "f3 2 5 enter", "f4 t a", "ctrl+p", "ctrl+p r e s",
                  "ctrl+p f down down", "f6 question_mark"]),
    (busy_arm, ["f7 slash a", "f7 e a", "f7 enter"]),
]  # fmt: skip


@pytest.mark.parametrize(("make", "lines"), TYPED_INTO)
async def test_a_stop_is_no_letter_and_no_choice_wherever_something_is_typed(make, lines):
    async with Session(make()) as session:
        session.arm.set(state=State.MOVING)
        for line in lines:
            await session.press("f2", *line.split())
            await session.settle()
            where = session.desk.screens.current.place
            session.arm.calls.clear()
            await session.press("space")
            await session.settle()
            asked = [call for call in session.arm.calls if call != ("release",)]
            assert asked == [("stop",)], line
            assert len(session.desk.screen_stack) == 1, line
            assert session.desk.screens.current.place == where, line
            assert "STOP requested" in session.text("messages"), line
