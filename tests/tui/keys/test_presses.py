"""Presses that count: a stop before all others, two presses of one key, and a pause before them."""

import contextlib
from functools import partial

import pytest
from desk_session import AGAIN_S, Session
from textual import events
from textual.drivers.headless_driver import HeadlessDriver

from armdrive.errors import BadRequest
from tui.app import action_call
from tui.keys.presses import ASKED_FOR_S, PERSON_S, QUIET_S, Confirmation, UrgentKeys
from tui.terminal import lasting_driver

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


class Part:
    def mark(self, by):
        return f"marked {by}"


class Node:
    steps = Part()

    def action_leave(self):
        return "left"


def test_an_action_is_a_method_of_a_node_or_of_one_of_its_parts():
    node = Node()
    assert action_call("leave", node)() == "left"
    assert action_call("steps.mark(-1)", node)() == "marked -1"
    for nothing in ("mark(1)", "steps.leave", "stages.mark(1)", "steps.action_leave"):
        assert action_call(nothing, node) is None


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
        for _ in range(3):
            read(session, "w", "w")
        read(session, *SPACE)
        assert session.arm.calls == [("stop",)]
        await session.pilot.pause()
        assert not {"nudge", "hold"} & {call[0] for call in session.arm.calls}
        assert not session.desk.screens.current.armed, "the app does the rest of the stop"
        assert "STOP" in session.desk.message
        await session.arm_keys()  # keys behind it count again
        read(session, "w", "w")
        await session.pilot.pause()
        session.clock.now_s += PERSON_S
        session.tick()
        assert session.arm.calls[-1][0] == "nudge"


@pytest.mark.parametrize("lost", [0, 1])
def test_a_stop_that_never_came_is_forgotten_with_the_next(lost):
    urgent, stopped = UrgentKeys(), []
    keys = [events.Key(*SPACE) for _ in range(2)]
    for key in keys:
        urgent.read(key, {"space": lambda: stopped.append(1)})
    assert len(stopped) == 2
    assert urgent.overtook(events.Key("w", "w"))
    for key in keys[lost:]:
        assert not urgent.overtook(key)
    assert not urgent.overtook(events.Key("w", "w"))


def test_other_keys_do_nothing_before_the_app_takes_them():
    urgent, stopped = UrgentKeys(), []
    urgent.read(events.Key("w", "w"), {"space": lambda: stopped.append(1)})
    assert not stopped
    assert not urgent.overtook(events.Key("q", "q"))
