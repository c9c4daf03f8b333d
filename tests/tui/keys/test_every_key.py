"""Each key of the table is pressed where its row counts, and leads to the deed of that row."""

import contextlib
from contextlib import asynccontextmanager
from functools import partial

import pytest
from amounts import every_row
from desk_fake import END, MODEL, FakeArm, FakeHolder, busy_arm
from desk_planner import CONFIG, PlannerArm
from desk_session import AGAIN_S, AppSession, Session
from textual import events
from textual.actions import parse
from textual.drivers.headless_driver import HeadlessDriver

from armdrive.errors import BadRequest
from armdrive.motion.dead_man import GATE_S
from armdrive.moves import Jog
from armdrive.status import State, status_view
from kinematics.textbook.study import subject_of_system
from kinematics.textbook.systems import system
from tui.keys.keyboard import DEFAULT_KEYS, KEYS_OFFERED, keyboard_of
from tui.keys.layouts import LAYOUTS
from tui.keys.presses import ASKED_FOR_S, QUIET_S, Confirmation, Freshness
from tui.keys.table import JOG_PAIRS, SCREENS, TABLE
from tui.model_desk import ModelDesk, model_keys
from tui.terminal import lasting_driver
from tui.watch import Watching
from tui.widgets import KeyLine, TypedText

PLACES_OF_SCREENS = {entry.id for entry in SCREENS}
OPENED_BY = {"dialog": ("log", "slash"), "question": ("jog", "H")}
"""Dialogs, by the screens and the keys that lead to them."""


@asynccontextmanager
async def at_screen(name):
    arm = busy_arm() if name == "log" else PlannerArm()
    arm.config = CONFIG
    async with Session(arm, first=name) as session:
        yield session.desk, session.pilot, DEFAULT_KEYS.at(name)


@asynccontextmanager
async def at_dialog(name):
    arm = busy_arm()
    arm.set(simulated=False)
    screen, key = OPENED_BY[name]
    async with Session(arm, first=screen) as session:
        await session.press(key)
        await session.settle()
        assert len(session.desk.screen_stack) == 2
        if name == "dialog":
            session.desk.screen.typing = TypedText(takes=lambda _: False)
        counting = tuple(row for row in TABLE if row.counts_at(name) or row.everywhere)
        yield session.desk, session.pilot, counting


@asynccontextmanager
async def running(app, rows):
    async with AppSession(app) as session:
        yield app, session.pilot, rows


def place(name):
    """Bring an app to a place; yields it, its pilot, and the rows that count there."""
    if name in PLACES_OF_SCREENS:
        return at_screen(name)
    if name == "watch":
        holder = FakeHolder(status_view(FakeArm().status), END)
        app = Watching("sim", MODEL, holder.views(), holder.ask, braille=True)
        return running(app, app.keys.rows)
    if name == "model":
        rows = model_keys().at("model")
        return running(ModelDesk(subject_of_system(system("puma")), braille=True), rows)
    return at_dialog(name)


def noting(app):
    """Have the app note every deed that a key leads to, and do none of them."""
    done = []

    async def note(action, default_namespace=None, namespaces=None):
        part, name, _ = parse(action)
        holder = app if part == "app" else default_namespace or app
        if part not in ("", "app"):
            holder = getattr(holder, part)
        else:
            name = f"action_{name}"
        assert callable(getattr(holder, name, None)), f"nothing does {action}"
        done.append(str(action))
        return True

    app.run_action = note
    app.action_stop_arm = lambda: done.append("stop_arm")
    return done


DEEDS = {action for row in TABLE for *_, action in row.bound}
DIALOGS = tuple(OPENED_BY)
PLACES = sorted({place for row in TABLE for place in row.places.split()})


@pytest.mark.parametrize("name", PLACES)
async def test_every_key_of_the_table_leads_to_the_deed_of_its_row(name):
    """Of a dialog, all other keys lead to no deed; scrolling and the like are the framework's."""
    async with place(name) as (app, pilot, rows):
        done = noting(app)
        wanted = [
            (name, key, action) for row in rows for name, keys, action in row.bound for key in keys
        ]
        assert wanted
        found = []
        for each, key, _ in wanted:
            done.clear()
            await pilot.press(key)
            found.append((each, key, " ".join(done)))
        assert found == wanted
        if name in DIALOGS:
            taken = {key for row in rows for key in row.all_keys}
            others = [key for row in TABLE for key in row.all_keys if key not in taken]
            assert others
            done.clear()
            for key in dict.fromkeys(others):
                await pilot.press(key)
            assert not DEEDS & set(done), "nothing of the screen goes through a dialog"


TYPED_INTO = [
    (PlannerArm, ["f3 2 5 enter", "f4 t a", "ctrl+p f down down", "f2 question_mark"]),
    (busy_arm, ["f7 slash a", "f7 enter"]),
]  # fmt: skip


@pytest.mark.parametrize(("make", "lines"), TYPED_INTO)
async def test_a_stop_is_no_letter_and_no_choice_wherever_something_is_typed(make, lines):
    async with Session(make()) as session:
        session.arm.set(state=State.MOVING)
        for line in lines:
            await session.press("f2", *line.split())
            await session.settle()
            where = session.desk.current.place
            session.arm.calls.clear()
            await session.press("space")
            await session.settle()
            asked = [call for call in session.arm.calls if call != ("release",)]
            assert asked == [("stop",)], line
            assert len(session.desk.screen_stack) == 1, line
            assert session.desk.current.place == where, line
            assert "STOP requested" in session.text("messages"), line


# The key table is complete, free of clashes, and the source of bindings, footer and help.


@every_row("place", [entry.id for entry in SCREENS])
def test_the_line_of_keys_and_the_help_are_made_from_the_table(place):
    rows, line = DEFAULT_KEYS.next_keys(place), KeyLine(id="keys")
    assert len(rows) <= KEYS_OFFERED
    for width in (12, 40, 80, 120, 300):
        line.show_keys(rows, width)
        assert line.shown.startswith("space STOP")
        assert len(line.shown.rstrip()) <= width
    listed = "\n".join(DEFAULT_KEYS.help(place, JOG_PAIRS))
    assert listed.startswith("Move the arm, on the jog screen (f2)")
    for row in TABLE:
        if (row.counts_at(place) or not row.places) and row.description and not row.jogs:
            assert row.tooltip in listed


# Presses that count: a stop before all others, two presses of one key, and a pause before them.


PAUSE_S = QUIET_S + 0.1
PRESSES = {
    # presses of keys by what they would do, a wait with a look after it, or "+" and a wait without
    "one press": (["deletes", PAUSE_S], [], "deletes"),
    "two presses": (["deletes", AGAIN_S, "deletes", PAUSE_S, PAUSE_S], ["deletes"], ""),
    "a held key": (["deletes", "+0.03", "deletes", "+0.03", "deletes", 1.0], [], "deletes"),
    "a key held for one repeat": (["moves", "+0.25", "moves", PAUSE_S, 1.0], [], "moves"),
    "for one late repeat": (["moves", "+0.7", "moves", PAUSE_S, 1.0], [], "moves"),
    "then pressed again": (["moves", "+0.5", "moves", AGAIN_S, "moves", PAUSE_S], ["moves"], ""),
    "then held again": (["moves", "+0.5", "moves", AGAIN_S, "moves", "+0.1", "moves", 1.0], [], ""),
    "another key": (["deletes", "+0.2", "moves", 1.0], [], "moves"),
    "another key twice": (["deletes", 1.0, "moves", 1.0, "moves", PAUSE_S], ["moves"], ""),
    "long ago": (["deletes", ASKED_FOR_S + 0.1], [], ""),
    "after that": (["deletes", ASKED_FOR_S + 0.1, "deletes", PAUSE_S], [], "deletes"),
    "far apart": (["moves", "+60", "moves"], [], "moves"),
    "far apart, then again": (["moves", "+60", "moves", "+1", "moves", 0.0], [], ""),
    "and a pause": (["moves", "+60", "moves", "+1", "moves", 0.5, 0.5], ["moves"], ""),
    # held while a preview is worked out, its later repeats would be two presses by themselves
    "refused": (["refused", "+0.05", "moves", "+0.05", "moves", PAUSE_S], [], ""),
    "refused, held": (["refused", "+0.5", "moves", "+0.05", "moves", PAUSE_S, 1.0], [], ""),
    "refused, then": (["refused", "+0.05", "moves", AGAIN_S, "moves", AGAIN_S, "moves", PAUSE_S],
                      ["moves"], ""),
    # a single press of what needs no second one; a paste goes on with the same key or another one
    "a step": (["steps", "+0.2", PAUSE_S, PAUSE_S], ["steps"], ""),
    "a step, too early": (["steps", QUIET_S - 0.1], [], ""),
    "a held step": (["steps", PAUSE_S, "steps", "+0.03", "steps", PAUSE_S], ["steps"], ""),
    "a step held for one repeat": (["steps", PAUSE_S, "+0.1", "steps", 1.0], ["steps"], ""),
    "two steps": (["steps", AGAIN_S, "steps", PAUSE_S], ["steps", "steps"], ""),
    "a step refused, then": (["refused", "+0.1", "steps", 0.8, "steps", 0.4], ["steps"], ""),
    "a step, then another key": (["steps", "+0.01", "moves", PAUSE_S], [], "moves"),
}  # fmt: skip


@pytest.mark.parametrize(("steps", "done", "effect"), PRESSES.values(), ids=PRESSES)
def test_enough_presses_of_one_key_are_done_once(steps, done, effect):
    now, found = [50.0], []
    confirmation = Confirmation(lambda: now[0])
    for step in steps:
        if step == "refused":
            confirmation.refuse()
        elif isinstance(step, float):
            now[0] += step
            if act := confirmation.due():
                act()
        elif step.startswith("+"):
            now[0] += float(step)
        else:
            needed = 1 if step == "steps" else 2
            with contextlib.suppress(BadRequest):
                confirmation.press(step, partial(found.append, step), needed=needed)
    assert found == done
    assert confirmation.effect == effect


# A stop acts in the thread that reads the keys; what was typed before it has no effect.

SPACE = ("space", " ")


def read(session, key, character):
    """Have the driver read a key, as its thread does; the app takes it later."""
    # a Pilot puts its own driver in its place
    driver = lasting_driver(HeadlessDriver)(session.desk)
    driver.process_message(events.Key(key, character))


async def test_a_stop_reaches_the_arm_before_the_app_and_what_it_overtook_moves_nothing():
    async with Session() as session:
        await session.arm_keys()
        session.arm.calls.clear()
        for key in "wwwR":
            read(session, key, key)
        read(session, *SPACE)
        assert session.arm.calls == [("stop",)]
        await session.settle()
        assert not {"nudge", "hold", "reset"} & {call[0] for call in session.arm.calls}
        assert not session.desk.current.armed, "the app does the rest of the stop"
        assert "STOP" in session.desk.message
        await session.arm_keys()  # keys behind it count again
        read(session, "w", "w")
        await session.pilot.pause()
        session.clock.now_s += GATE_S
        session.tick()
        assert session.arm.calls[-1][0] == "nudge"


def test_only_keys_that_were_typed_before_a_stop_are_overtaken():
    fresh = Freshness()
    keys = [events.Key(*key) for key in (("w", "w"), SPACE, ("q", "q"), SPACE, ("e", "e"))]
    assert not any(map(fresh.overtaken, keys))
    fresh.acted(keys[1].time)
    assert [fresh.overtaken(key) for key in keys] == [True, False, False, False, False]
    fresh.acted(keys[3].time)
    assert [fresh.overtaken(key) for key in keys] == [True, True, True, False, False]


# Other keyboards, and that the desk then hears their keys.


def test_qwerty_is_the_table_and_so_is_a_layout_that_was_never_known():
    assert keyboard_of("qwerty") == keyboard_of("") == keyboard_of("azery") == DEFAULT_KEYS


@every_row("layout", LAYOUTS)
def test_no_key_of_a_layout_does_two_things_at_one_place(layout):
    keyboard = keyboard_of(layout)
    assert [row.id for row in keyboard.rows] == [row.id for row in TABLE]
    for place in ("", *PLACES):
        # what counts in dialogs need not differ from the screens': nothing goes through a dialog
        on_screen = place in PLACES_OF_SCREENS
        rows = (
            r
            for r in keyboard.rows
            if r.counts_at(place) or r.everywhere or (on_screen and not r.places)
        )
        keys = [key for row in rows for key in row.all_keys]
        assert len(keys) == len(set(keys)), place


async def test_the_desk_hears_and_shows_the_keys_of_the_layout():
    async with Session(keys=keyboard_of("azerty")) as session:
        await session.arm_keys()
        await session.tap("a", "q", "z", after_s=3.0)
        jogs = [call[1] for call in session.arm.asked("nudge")]
        assert jogs == [Jog.joint(base=2.0), Jog.joint(base=-2.0), Jog.joint(shoulder=2.0)]
        assert " a  q   base" in session.text("joints")
        await session.press("w", after_s=3.0)
        assert len(session.arm.asked("nudge")) == 3, "w is no key any more"
        await session.press("comma")
        assert "step [1°] 2 mm" in session.text("stopping")
