"""Presses that count: a pause before one, two of one key, and no other key between them."""

from functools import partial

import pytest

from tui.app import action_call
from tui.keys.presses import ASKED_FOR_S, QUIET_S, Confirmation, SinglePress


def test_a_key_that_is_held_counts_once():
    times_s = iter((0.0, 0.1, 0.2, 0.6, 1.1, 1.7))
    presses = SinglePress(lambda: next(times_s), 0.5)
    assert [presses.counts() for _ in range(6)] == [True, False, False, False, True, True]


PAUSE_S = QUIET_S + 0.1
PRESSES = {
    # presses of keys by what they would do, a wait with a look after it, or "+" and a wait without
    "one press": (["deletes", PAUSE_S], [], "deletes"),
    "two presses": (["deletes", PAUSE_S, "deletes", PAUSE_S, PAUSE_S], ["deletes"], ""),
    "a held key": (["deletes", "+0.03", "deletes", "+0.03", "deletes", 1.0], [], ""),
    "another key": (["deletes", "+0.2", "moves", 1.0], [], "moves"),
    "another key twice": (["deletes", 1.0, "moves", 1.0, "moves", PAUSE_S], ["moves"], ""),
    "long ago": (["deletes", ASKED_FOR_S + 0.1], [], ""),
    "after that": (["deletes", ASKED_FOR_S + 0.1, "deletes", PAUSE_S], [], "deletes"),
    "far apart": (["moves", "+60", "moves"], [], "moves"),
    "far apart, then again": (["moves", "+60", "moves", "+1", "moves", 0.0], [], ""),
    "and a pause": (["moves", "+60", "moves", "+1", "moves", 0.5, 0.5], ["moves"], ""),
    # held while a preview is worked out, its later repeats would be two presses by themselves
    "refused": (["refused", "+0.05", "moves", "+0.05", "moves", PAUSE_S], [], ""),
    "refused, then": (["refused", "+0.05", "moves", PAUSE_S, "moves", "moves", PAUSE_S],
                      ["moves"], ""),
}  # fmt: skip


@pytest.mark.parametrize(("steps", "done", "effect"), PRESSES.values(), ids=PRESSES)
def test_two_presses_of_one_key_are_done_once(steps, done, effect):
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
            confirmation.press(step, partial(found.append, step))
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
