"""Presses that count: a pause before one, two of one key, and no other key between them."""

from tui.app import action_call
from tui.keys.presses import ASKED_FOR_S, QUIET_S, Confirmation, SinglePress


class Hand:
    """Presses keys on a clock of its own."""

    def __init__(self):
        self.now_s = 50.0
        self.done = []
        self.confirmation = Confirmation(lambda: self.now_s)

    def press(self, effect, after_s=0.0):
        self.now_s += after_s
        self.confirmation.press(effect, lambda: self.done.append(effect))

    def wait(self, time_s):
        self.now_s += time_s
        if act := self.confirmation.due():
            act()


def test_a_key_that_is_held_counts_once():
    times_s = iter((0.0, 0.1, 0.2, 0.6, 1.1, 1.7))
    presses = SinglePress(lambda: next(times_s), 0.5)
    assert [presses.counts() for _ in range(6)] == [True, False, False, False, True, True]


def test_two_presses_of_one_key_are_done_once():
    hand = Hand()
    hand.press("deletes up")
    hand.wait(QUIET_S + 0.1)
    assert hand.done == []
    assert hand.confirmation.effect == "deletes up"
    hand.press("deletes up")
    hand.wait(QUIET_S + 0.1)
    hand.wait(QUIET_S + 0.1)
    assert hand.done == ["deletes up"]
    assert hand.confirmation.effect == ""


def test_another_key_starts_over():
    hand = Hand()
    hand.press("deletes up")
    hand.press("moves up", after_s=0.2)
    hand.wait(1.0)
    assert hand.done == []
    assert hand.confirmation.effect == "moves up"
    hand.press("moves up")
    hand.wait(QUIET_S + 0.1)
    assert hand.done == ["moves up"]


def test_a_first_press_is_forgotten_after_a_while():
    hand = Hand()
    hand.press("deletes up")
    hand.wait(ASKED_FOR_S + 0.1)
    assert hand.confirmation.effect == ""
    hand.press("deletes up")
    hand.wait(QUIET_S + 0.1)
    assert hand.done == []


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


def test_the_repeats_of_a_key_that_was_refused_confirm_nothing():
    """Held while a preview is worked out, its later repeats would be two presses by themselves."""
    hand = Hand()
    hand.confirmation.refuse()
    for _ in range(2):
        hand.press("moves", after_s=0.05)
    hand.wait(QUIET_S + 0.1)
    assert hand.done == []
    hand.press("moves")
    hand.press("moves")
    hand.wait(QUIET_S + 0.1)
    assert hand.done == ["moves"]


def test_two_presses_far_apart_are_two_first_ones():
    hand = Hand()
    hand.press("moves")
    hand.press("moves", after_s=60.0)
    assert hand.confirmation.effect == "moves"
    hand.press("moves", after_s=1.0)
    hand.wait(0.0)
    assert hand.done == []
    hand.wait(0.5)
    hand.wait(0.5)
    assert hand.done == ["moves"]
