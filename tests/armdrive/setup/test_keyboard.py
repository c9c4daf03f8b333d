"""`doctor --keyboard`: what is said of keyboards that hold well, badly, unevenly or not at all."""

import random

import pytest
from amounts import every_row

from armdrive.setup.keyboard import KeyEvents, examine, held

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
    assert 0.12 <= found.released_s <= 0.25 + 1e-9
    assert examined(times=press(rate_hz)).remedies == []


HEAPS = [max(at, 2.0) if 1.0 < at <= 2.0 else at for at in press(30)]


@every_row(
    "times, works, remedy",
    [
        (press(30, delay_s=0.9), True, "shorter delay"),
        (press(6, lasts_s=5.0), True, "faster repeat"),
        (HEAPS, False, "bursts"),
        ([at for at in press(30) if not 1.0 < at < 1.4], False, "ends the jog"),
        ([0.0], False, "single increments"),
        ([0.0, 0.4, 0.5], False, "hold the key longer"),
        ([], False, "did not repeat"),
    ],
)
def test_what_keeps_a_held_key_from_working_is_named_with_the_remedy(times, works, remedy):
    found = examined(times=times)
    assert remedy in found.remedies[0]
    assert found.works is works
    assert found.press.events == len(times)
    assert ("will work" in found.lines[-1]) is works


def test_a_gap_that_would_end_the_jog_is_counted():
    assert held([at for at in press(30) if not 1.0 < at < 1.4]).breaks == 1
    assert "1 event" in str(held([0.0]))


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


@every_row(
    "answers, environment, focus, releases, remedies",
    [
        (b"\x1b[?1004;2$y\x1b[?62c", {}, True, False, []),
        (b"\x1b[?1u\x1b[?1004;2$y\x1b[?62c", {}, True, True, []),
        (b"\x1b[?1004;0$y\x1b[?62c", {"TMUX": "x"}, False, False, ["focus-events", "escape-time"]),
        (b"", {}, None, False, ["only the dead-man switch"]),  # and no reason to hang
    ],
)
def test_what_a_terminal_can_report_is_asked(answers, environment, focus, releases, remedies):
    found = examined(answers, **environment)
    assert (found.works, found.focus, found.releases) == (True, focus, releases)
    for wanted, remedy in zip(remedies, found.remedies, strict=True):
        assert wanted in remedy
    assert found.view()["remedies"] == found.remedies
