"""The dead-man on synthetic keyboards, links that jitter and links that stall."""

import math

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from armdrive.motion.dead_man import (
    ARM_AFTER_QUIET_S,
    BACKLOG_REASON,
    BURST_EVENTS,
    GATE_S,
    HOLD_LONGEST_S,
    HOLD_SHORTEST_S,
    DeadMan,
    Disarm,
    HeldKey,
    Increment,
    Release,
)

KEYBOARDS_HZ = (11.0, 25.0, 33.0)


def armed(now_s=0.0):
    deadman = DeadMan()
    assert deadman.arm(now_s)
    return deadman


class Desk:
    """Feeds a dead-man at its own deadlines, and writes down what it said and when."""

    def __init__(self, start_s=0.0):
        self.deadman = armed(start_s)
        self.log = []

    def until(self, now_s):
        while (due_s := self.deadman.next_s()) <= now_s and due_s < math.inf:
            self.note(due_s, self.deadman.tick(due_s))

    def key(self, key, now_s):
        self.until(now_s)
        self.note(now_s, self.deadman.press(key, now_s))

    def note(self, now_s, actions):
        self.log += [(now_s, action) for action in actions]

    def run(self, events):
        for now_s, key in events:
            self.key(key, now_s)
        self.until(math.inf)
        return self

    def of(self, kind):
        return [action for _, action in self.log if isinstance(action, kind)]


def keyboard(rate_hz, held_s, *, start_s=1.0, delay_s=0.4, key="q"):
    """Key events of one long press: the first, then repeats after the initial delay."""
    times, now_s = [start_s], start_s + delay_s
    while now_s <= start_s + held_s:
        times.append(now_s)
        now_s += 1.0 / rate_hz
    return [(time_s, key) for time_s in times]


def jittered(events, draw, most_s=0.06):
    """Delay every event by up to `most_s`, in order, as a link does."""
    arrived, last_s = [], -math.inf
    for time_s, key in events:
        last_s = max(last_s, time_s + draw() * most_s)
        arrived.append((last_s, key))
    return arrived


def stalled(events, start_s, end_s):
    """Keep back what falls into the stall, and deliver it at its end at wire speed."""
    arrived, spent_s = [], 0.0
    for time_s, key in events:
        if start_s < time_s < end_s:
            spent_s += 0.001
            time_s = end_s + spent_s
        arrived.append((time_s, key))
    return sorted(arrived)


def holding(rate_hz=25.0, held_s=1.0):
    """Return a desk at which a key is being held."""
    desk = Desk()
    for time_s, key in keyboard(rate_hz, held_s):
        desk.key(key, time_s)
    return desk


def test_keys_have_no_effect_until_armed():
    deadman = DeadMan()
    assert not deadman.armed
    assert deadman.press("q", 0.0) == ()
    assert deadman.next_s() == math.inf


def test_a_first_press_is_exactly_one_increment_once_no_other_key_has_followed():
    deadman = armed()
    assert deadman.press("q", 1.0) == ()
    assert deadman.next_s() == 1.0 + GATE_S
    assert deadman.tick(1.0 + GATE_S) == (Increment("q"),)
    assert deadman.tick(1.7) == ()
    assert deadman.next_s() == math.inf


def test_a_repeat_soon_after_means_held():
    desk = Desk().run([(1.0, "q"), (1.5, "q")])
    assert desk.log == [
        (1.0 + GATE_S, Increment("q")),
        (1.5 + GATE_S, HeldKey("q", 1.5 + HOLD_LONGEST_S)),
        (1.5 + HOLD_LONGEST_S, Release("q")),
    ]


def test_a_second_press_long_after_is_a_second_increment():
    desk = Desk().run([(1.0, "q"), (1.8, "q"), (5.0, "q")])
    assert [type(action) for _, action in desk.log] == [Increment, Increment, Increment]
    assert [time_s for time_s, _ in desk.log] == [
        pressed_s + GATE_S for pressed_s in (1.0, 1.8, 5.0)
    ]


@pytest.mark.parametrize("rate_hz", KEYBOARDS_HZ)
def test_a_hold_expires_three_intervals_after_the_last_repeat(rate_hz):
    events = keyboard(rate_hz, 2.0)
    desk = Desk().run(events)
    patience_s = min(max(3.0 / rate_hz, HOLD_SHORTEST_S), HOLD_LONGEST_S)
    ended_s, last = desk.log[-1]
    assert last == Release("q")
    assert ended_s == pytest.approx(events[-1][0] + patience_s)
    assert len(desk.of(Increment)) == 1
    assert len(desk.of(Release)) == 1


def test_another_key_replaces_the_held_one():
    desk = holding()
    desk.key("w", 2.05)
    assert desk.log[-1] == (2.05, Release("q"))
    desk.until(2.05 + GATE_S)
    assert desk.log[-1] == (2.05 + GATE_S, Increment("w"))


def test_a_key_just_after_a_repeat_of_the_held_one_waits_for_the_gate():
    desk, soon_s = holding(), keyboard(25.0, 1.0)[-1][0] + 0.01
    desk.key("w", soon_s)
    desk.until(soon_s + GATE_S)
    assert desk.log[-1] == (pytest.approx(soon_s + GATE_S), Increment("w"))


def test_a_repeat_that_another_key_joins_at_once_begins_nothing():
    desk = Desk().run([(1.0, "q"), (1.4, "q"), (1.41, "w")])
    assert [type(action) for _, action in desk.log] == [Increment]


def test_a_gated_press_that_is_found_too_late_is_dropped():
    deadman = armed()
    deadman.press("q", 2.0)
    assert deadman.tick(2.0 + HOLD_LONGEST_S) == ()


def test_release_all_ends_the_hold_and_gates_what_is_still_on_its_way():
    desk = holding()
    assert desk.deadman.release_all() == (Release("q"),)
    assert desk.deadman.held is None
    assert desk.deadman.press("q", 2.05) == ()


def test_a_release_that_is_reported_ends_the_hold_at_once():
    desk = holding()
    assert desk.deadman.key_up("w", 2.0) == ()
    assert desk.deadman.key_up("q", 2.01) == (Release("q"),)
    assert desk.deadman.held is None
    assert desk.deadman.armed


def test_a_release_of_a_tap_takes_nothing_back_and_one_of_a_first_repeat_begins_nothing():
    deadman = armed()
    assert deadman.press("q", 1.0) == ()
    assert deadman.key_up("q", 1.02) == ()
    assert deadman.key_up("q", 1.08) == (Increment("q"),)
    assert deadman.press("q", 5.0) == ()
    assert deadman.tick(5.0 + GATE_S) == (Increment("q"),)
    assert deadman.press("q", 5.4) == ()
    assert deadman.next_s() == 5.4 + GATE_S
    assert deadman.key_up("q", 5.41) == ()
    assert deadman.tick(5.5) == ()


def test_disarming_ends_the_hold_and_says_why_once():
    desk = holding()
    assert desk.deadman.disarm("focus lost") == (Release("q"), Disarm("focus lost"))
    assert desk.deadman.disarm("focus lost") == ()
    assert desk.deadman.press("q", 3.0) == ()


def test_arming_waits_until_the_keys_are_quiet():
    deadman = armed()
    deadman.disarm("for the test")
    deadman.press("q", 1.0)
    assert not deadman.arm(1.0 + ARM_AFTER_QUIET_S / 2)
    assert deadman.arm(1.0 + ARM_AFTER_QUIET_S)


@every_row("delay_s", [0.2, 0.4, 0.66])
@every_row("rate_hz", KEYBOARDS_HZ)
def test_a_stall_of_a_second_moves_nothing_and_disarms(rate_hz, delay_s):
    events = keyboard(rate_hz, 4.0, delay_s=delay_s)
    stalled_s = next(time_s for time_s, _ in events if time_s > 2.5) + 0.001
    before = [event for event in events if event[0] < stalled_s]
    desk = Desk().run(before)
    quiet = len(desk.of(Increment)), len(desk.of(HeldKey))
    desk = Desk().run(stalled(events, stalled_s, stalled_s + 1.0))
    assert (len(desk.of(Increment)), len(desk.of(HeldKey))) == quiet
    assert desk.of(Disarm) == [Disarm(BACKLOG_REASON)]
    assert not desk.deadman.armed


@pytest.mark.parametrize("stall_s", [0.5, 1.0, 1.9])
def test_a_stall_that_begins_right_after_the_first_press_moves_nothing_more(stall_s):
    desk = Desk().run(stalled(keyboard(33.0, 3.0), 1.01, 1.01 + stall_s))
    assert len(desk.of(Increment)) == 1
    assert desk.of(Disarm) == [Disarm(BACKLOG_REASON)]
    assert desk.of(HeldKey) == []


@every_row("gap_s", [0.0, 0.001, 0.02])
@every_row("text", ["qw", "qq", "qwe", "wwq", "qwertyqwerty"])
def test_pasted_text_moves_nothing(text, gap_s):
    desk = Desk().run([(1.0 + gap_s * count, key) for count, key in enumerate(text)])
    assert desk.of(Increment) == desk.of(HeldKey) == []
    assert (desk.of(Disarm) != []) == (len(text) > BURST_EVENTS and gap_s < 0.02)


def test_repeats_that_come_too_fast_for_any_keyboard_disarm_though_they_do_not_come_at_once():
    events = [(1.0, "q"), *((1.4 + 0.004 * number, "q") for number in range(12))]
    desk = Desk().run(events)
    assert desk.of(HeldKey) == []
    assert desk.of(Disarm) == [Disarm(BACKLOG_REASON)]


@pytest.mark.parametrize("busy_s", [0.0, 0.02, 0.035])
def test_the_fastest_keyboard_on_a_busy_computer_holds_without_a_backlog(busy_s):
    """A key repeats every 15 ms, and nothing is read for 35 ms every now and then."""
    for first_ms in range(0, 700, 5):
        events = keyboard(1 / 0.015, 1.5, delay_s=0.25)
        at_s = 1.0 + first_ms / 1000
        late = [(at_s + busy_s if at_s < t < at_s + busy_s else t, key) for t, key in events]
        desk = Desk().run(late)
        assert desk.of(Disarm) == []
        assert len(desk.of(Increment)) == 1
        assert len(desk.of(Release)) == 1


jitter = st.randoms(use_true_random=False)


@given(st.sampled_from(KEYBOARDS_HZ), st.floats(0.2, 0.66), st.floats(0.0, 4.0), jitter)
def test_jitter_never_disarms_interrupts_or_overruns(rate_hz, delay_s, held_s, noise):
    events = jittered(keyboard(rate_hz, held_s, delay_s=delay_s), noise.random)
    desk = Desk().run(events)
    assert desk.of(Disarm) == []
    assert len(desk.of(Increment)) == 1
    assert len(desk.of(Release)) <= 1
    assert desk.log[-1][0] <= events[-1][0] + HOLD_LONGEST_S


event_times = st.lists(
    st.tuples(st.sampled_from([0.0, 0.001, 0.01, 0.03, 0.1, 0.3, 0.7, 2.5]), st.sampled_from("qw")),
    min_size=1,
    max_size=40,
)


QUARTER_S = 0.25
"""What docs and people are told, whatever the code's own number may become."""


@given(event_times)
def test_nothing_is_in_force_a_quarter_second_after_the_last_event(gaps):
    """And every hold is released before anything else begins."""
    desk, now_s = Desk(), 1.0
    for gap_s, key in gaps:
        now_s += gap_s
        desk.key(key, now_s)
        assert all(hold.until_s <= now_s + QUARTER_S for hold in desk.of(HeldKey))
        assert desk.deadman.next_s() <= now_s + QUARTER_S or desk.deadman.held is None
    desk.until(now_s + QUARTER_S)
    assert desk.deadman.held is None
    assert desk.deadman.next_s() == math.inf
    held = None
    for _, action in desk.log:
        if isinstance(action, HeldKey):
            assert held in (None, action.key)
            held = action.key
        elif isinstance(action, Release):
            assert held == action.key
            held = None
        else:
            assert held is None
    assert held is None


@given(
    st.sampled_from(KEYBOARDS_HZ),
    st.floats(0.3, 1.9),
    st.integers(2, 60),
    st.floats(0.0, 0.0025),
    st.sampled_from(["q", "w"]),
)
def test_backlog_after_a_hold_never_moves_anything(rate_hz, silence_s, count, gap_s, key):
    desk, again_s = holding(rate_hz, 1.5), keyboard(rate_hz, 1.5)[-1][0] + silence_s
    desk.until(again_s)
    before = len(desk.of(Increment)), len(desk.of(HeldKey))
    for index in range(count):
        desk.key(key, again_s + index * gap_s)
    desk.until(math.inf)
    assert (len(desk.of(Increment)), len(desk.of(HeldKey))) == before
    backlog = [Disarm(BACKLOG_REASON)] if count >= BURST_EVENTS else []
    assert desk.of(Disarm) == backlog


@given(st.lists(st.floats(0.0, 0.4), min_size=1, max_size=30), st.floats(0.0, 2.0))
def test_a_late_tick_changes_when_but_never_gives_stale_motion(gaps, late_s):
    """The desk's loop may be busy: whatever is given late must still be fresh."""
    deadman, now_s, event_s = armed(), 1.0, 1.0
    for gap_s in gaps:
        now_s += gap_s
        deadman.press("q", now_s)
        event_s = now_s
    given_late = deadman.tick(event_s + late_s)
    if late_s >= HOLD_LONGEST_S:
        assert not any(isinstance(action, Increment | HeldKey) for action in given_late)
