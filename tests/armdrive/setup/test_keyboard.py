"""`doctor --keyboard`: what is said of keyboards that hold well, badly, unevenly or not at all."""

import random

import pytest
from amounts import every_row

from armdrive.setup.keyboard import KeyEvents, advice, examine, held, sentence

RIGHT = b"\x1b[C"


def press(rate_hz, *, delay_s=0.4, lasts_s=3.0, jitter_s=0.0, seed=0):
    draw = random.Random(seed)
    times, at = [0.0], delay_s
    while at < lasts_s:
        times.append(at + draw.uniform(0.0, jitter_s))
        at += 1.0 / rate_hz
    return times


class FakeTerminal:
    """Answers questions, then gives a press; its clock goes on while it is read."""

    def __init__(self, answers, times):
        self.time_s = 0.0
        self.events = [(0.01, answers)] if answers else []
        self.times = times
        self.written = b""

    def write(self, data):
        self.written += data

    def read(self, timeout_s):
        until_s = self.time_s + timeout_s
        if not self.events or self.events[0][0] > until_s:
            self.time_s = until_s
            return b""
        self.time_s, data = self.events.pop(0)
        return data

    def now_s(self):
        return self.time_s

    def tell(self, _text):
        start_s = self.time_s + 1.0
        self.events = [(start_s + at, RIGHT) for at in self.times]


def examined(answers=b"\x1b[?1004;2$y\x1b[?62c", times=None, **environment):
    terminal = FakeTerminal(answers, press(30) if times is None else times)
    return examine(terminal, environment, terminal.tell)


@every_row("rate_hz", [12, 15, 25, 33])
def test_usual_keyboards_hold(rate_hz):
    found = held(press(rate_hz))
    assert found.works
    assert found.rate_hz == pytest.approx(rate_hz)
    assert found.delay_s == pytest.approx(0.4)
    assert not advice(found)
    assert 0.12 <= found.released_s <= 0.25 + 1e-9


def test_a_long_delay_and_few_repeats_are_named_with_the_remedy():
    late = held(press(30, delay_s=0.9))
    assert "shorter delay" in advice(late)[0]
    slow = held(press(6, lasts_s=5.0))
    assert any("faster repeat" in each for each in advice(slow))


def test_a_key_that_does_not_repeat_means_single_increments():
    found = held([0.0])
    assert not found.works
    assert "single increments" in advice(found)[0]
    assert "1 event" in sentence(found)


def test_a_link_that_delivers_in_heaps_is_seen_to():
    times = press(30)
    stalled = [max(at, 2.0) if 1.0 < at <= 2.0 else at for at in times]
    found = held(stalled)
    assert not found.works
    assert advice(found)


def test_a_gap_that_would_end_the_jog_is_counted():
    times = [at for at in press(30) if not 1.0 < at < 1.4]
    found = held(times)
    assert found.breaks == 1
    assert found.longest_s == pytest.approx(0.4, abs=0.05)


def test_sequences_cut_by_a_read_are_put_together():
    sent = [RIGHT, b"x", b"\x1b[?1004;1$y", b"\x1b[?0u", b"\x1b[?64;1;2c"]
    events = KeyEvents()
    assert [each for byte in b"".join(sent) for each in events.feed(bytes([byte]))] == sent


def test_a_late_answer_of_the_terminal_is_no_key():
    terminal = FakeTerminal(b"", press(30))
    hold = terminal.tell

    def late(text):
        hold(text)
        terminal.events.insert(0, (terminal.time_s + 0.5, b"\x1b[?62c"))

    terminal.tell = late
    assert examine(terminal, {}, terminal.tell).press.rate_hz == pytest.approx(30)


def test_a_good_terminal_is_told_so():
    found = examined()
    assert (found.works, found.focus, found.releases) == (True, True, False)
    assert found.remedies == []
    assert "will work" in found.verdict


def test_tmux_without_focus_events_gets_the_line_for_its_file():
    found = examined(b"\x1b[?1004;0$y\x1b[?62c", TMUX="/tmp/x")
    assert any("focus-events on" in each for each in found.remedies)
    assert any("escape-time" in each for each in found.remedies)


def test_a_terminal_that_answers_nothing_is_no_reason_to_hang():
    found = examined(b"")
    assert found.focus is None
    assert found.works


def test_without_a_key_press_the_examination_says_that_holding_does_not_work():
    found = examined(times=[])
    assert found.press.events == 0
    assert not found.works


def test_a_terminal_that_tells_releases():
    assert examined(b"\x1b[?1u\x1b[?62c").releases
