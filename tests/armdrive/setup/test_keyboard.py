"""`doctor --keyboard`: what is said of keyboards that hold well, badly, unevenly or not at all."""

import pytest
from amounts import every_row

from armdrive.setup.keyboard import examine, held

RIGHT = b"\x1b[C"


def press(rate_hz, *, delay_s=0.4, lasts_s=3.0):
    count = int((lasts_s - delay_s) * rate_hz)
    return [0.0, *(delay_s + each / rate_hz for each in range(count))]


class FakeTerminal:
    """Gives a press of one key, byte by byte; its clock goes on while it is read."""

    def __init__(self, times):
        self.time_s = 0.0
        self.events = [(1.0 + at, bytes([each])) for at in times for each in RIGHT]

    def read(self, timeout_s):
        until_s = self.time_s + timeout_s
        if not self.events or self.events[0][0] > until_s:
            self.time_s = until_s
            return b""
        self.time_s, data = self.events.pop(0)
        return data

    def now_s(self):
        return self.time_s


def examined(times, **environment):
    return examine(FakeTerminal(times), environment, lambda _text: None)


@every_row("rate_hz", [12, 15, 25, 33])
def test_usual_keyboards_hold(rate_hz):
    found = examined(press(rate_hz))
    assert found.works
    assert found.rate_hz == pytest.approx(rate_hz)
    assert found.delay_s == pytest.approx(0.4)
    assert 0.12 <= found.released_s <= 0.25 + 1e-9
    assert not list(found.remedies())


HEAPS = [max(at, 2.0) if 1.0 < at <= 2.0 else at for at in press(30)]
BACKLOG = [0.0, *(0.4 + each * 0.004 for each in range(7))]  # so fast only at its last event
GAP = [at for at in press(30) if not 1.0 < at < 1.4]


@every_row(
    "times, works, remedy",
    [
        (press(30, delay_s=0.9), True, "shorter delay"),
        (press(6, lasts_s=5.0), True, "faster repeat"),
        (HEAPS, False, "bursts"),
        (GAP, False, "ended the jog"),
        (BACKLOG, False, "bursts"),
        ([0.0], False, "single increments"),
        ([0.0, 0.4, 0.5], False, "hold the key longer"),
        ([], False, "did not repeat"),
    ],
)
def test_what_keeps_a_held_key_from_working_is_named_with_the_remedy(times, works, remedy):
    found = examined(times)
    assert remedy in next(found.remedies())
    assert found.works is works
    assert found.events == len(times)
    assert ("will work" in found.lines[-1]) is works
    view = found.view()
    assert (view["works"], view["remedies"], view["held"]["events"]) == (
        works,
        list(found.remedies()),
        len(times),
    )


def test_another_key_is_no_repeat():
    terminal = FakeTerminal(press(30))
    terminal.events.insert(9, (terminal.events[8][0], b"x"))
    found = examine(terminal, {}, lambda _text: None)
    assert found.events == len(press(30))


def test_a_gap_that_would_end_the_jog_is_counted_and_tmux_has_its_settings_named():
    assert held(GAP).breaks == 1
    assert "1 event" in str(held([0.0]))
    (remedy,) = examined(press(30), TMUX="x").remedies()
    assert "focus-events" in remedy
    assert "escape-time" in remedy
