"""How keys repeat in a terminal, and whether that is enough to jog by a held key."""

from __future__ import annotations

import contextlib
import math
import os
import re
import select
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from statistics import median
from typing import Any

from armdrive.motion.dead_man import (
    HOLD_INTERVALS,
    HOLD_LONGEST_S,
    REPEAT_WITHIN_S,
    DeadMan,
    Disarm,
    Release,
)
from kinematics.text import counted

if sys.platform != "win32":
    import termios
    import tty
else:
    import msvcrt

# Whether a held key can keep an arm moving: how the desk's dead-man switch treats its repeats.
#
# The verdict is no guess: the dead-man switch itself (motion/dead_man.py) gets the same events.

# The fewest repeats from which a rate can be measured.
FEWEST_REPEATS = 5
# The longest usual interval; a measured rate that is a twentieth too slow is no fault.
SLOWEST_S = HOLD_LONGEST_S / HOLD_INTERVALS * 1.05
# The dead-man switch is armed this long before the first press, as in a desk that is open.
QUIET_S = 1.0


@dataclass(frozen=True, slots=True)
class Held:
    """One long press: its events, the delay of the first repeat and the usual interval.

    Both times are None if too few repeats came. `released_s` is how long after the last repeat the
    jog would end, `breaks` how often it would have ended while the key was held, also because the
    dead-man switch took the repeats for a backlog. `tmux` is whether tmux passes them.
    """

    events: int
    delay_s: float | None = None
    interval_s: float | None = None
    released_s: float | None = None
    breaks: int = 0
    tmux: bool = False

    @property
    def works(self) -> bool:
        """Whether holding a key moves an arm smoothly, and only while the key is held."""
        return self.interval_s is not None and not self.breaks

    @property
    def rate_hz(self) -> float | None:
        """The repeats per second."""
        return 1.0 / self.interval_s if self.interval_s else None

    def __str__(self) -> str:
        if self.delay_s is None or self.rate_hz is None:
            return f"{counted(self.events, 'event')} of the held key came"
        first = f"first repeat after {self.delay_s * 1e3:.0f} ms, then {self.rate_hz:.0f} a second"
        if self.released_s is None:
            return first
        return f"{first}. A release is noticed after {self.released_s * 1e3:.0f} ms"

    def remedies(self) -> Iterator[str]:
        """Yield the remedies, that of the worst problem first."""
        if self.delay_s is None:
            yield (
                "the key did not repeat: switch key repeat on (X11: xset r on; macOS, for letters: "
                "defaults write -g ApplePressAndHoldEnabled -bool false, then a new login), or jog "
                "by single increments"
            )
        elif self.delay_s > REPEAT_WITHIN_S:
            yield (
                f"the first repeat came after {self.delay_s * 1e3:.0f} ms; a hold is recognised "
                f"within {REPEAT_WITHIN_S * 1e3:.0f} ms: set a shorter delay (X11: xset r rate 300 "
                "30; Windows, macOS and Wayland: in the keyboard settings)"
            )
        elif self.interval_s is None:
            yield "too few repeats came to measure their rate: hold the key longer"
        elif self.breaks or self.interval_s > SLOWEST_S:
            yield (
                "repeats came late or in bursts, so the dead-man switch ended the jog while the "
                "key was held: set a faster repeat, 20 to 30 a second, use a faster link, or jog "
                "by single increments"
            )
        if self.tmux:
            yield (
                "in tmux, put `set -g focus-events on` and `set -s escape-time 10` into "
                "~/.tmux.conf: a jog then ends when you click elsewhere, and Esc acts at once"
            )

    @property
    def verdict(self) -> str:
        """The verdict in one sentence."""
        if self.works:
            return "holding a key to jog will work here"
        return "holding a key will not work here: jog by single increments, one press each"

    @property
    def lines(self) -> list[str]:
        """All of it as text."""
        remedies = [f"- {remedy}." for remedy in self.remedies()]
        return [f"Held key: {self}.", *remedies, f"Verdict: {self.verdict}."]

    def view(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        measured = asdict(self) | {"rate_hz": self.rate_hz}
        tmux = measured.pop("tmux")
        return {
            "held": measured,
            "tmux": tmux,
            "works": self.works,
            "verdict": self.verdict,
            "remedies": list(self.remedies()),
        }


def held(times_s: Sequence[float], *, tmux: bool = False) -> Held:
    """Measure one long press from the times of its events, the first press included."""
    gaps = [after - before for before, after in pairwise(times_s)]
    if len(gaps) <= FEWEST_REPEATS:
        return Held(len(times_s), gaps[0] if gaps else None, tmux=tmux)
    switch = DeadMan()
    switch.arm(times_s[0] - QUIET_S)
    ends: list[float] = []
    for time_s in (*times_s, math.inf):
        while (due_s := switch.next_s()) < time_s:
            ends += [due_s for each in switch.tick(due_s) if isinstance(each, Release)]
        if time_s < math.inf:
            actions = switch.press("held", time_s)
            ends += [time_s for each in actions if isinstance(each, Release | Disarm)]
    last_s = times_s[-1]
    after = [end_s - last_s for end_s in ends if end_s > last_s]
    released_s = after[0] if after else None
    return Held(len(times_s), gaps[0], median(gaps[1:]), released_s, len(ends) - len(after), tmux)


# A terminal that passes on every byte at once, and is restored afterwards.


class RawTerminal:
    """The terminal of this process, which neither echoes keys nor collects them into lines."""

    def read(self, timeout_s: float) -> bytes:
        """Return the bytes that have come, waiting for at most `timeout_s`."""
        number = sys.stdin.fileno()
        ready, _, _ = select.select([number], [], [], timeout_s)
        return os.read(number, 4096) if ready else b""

    def now_s(self) -> float:
        """Return the time of a monotonic clock."""
        return time.perf_counter()


class _Console(RawTerminal):
    """Windows: keys come one by one; a short sleep between looks is precise enough."""

    LOOK_S = 0.002

    def read(self, timeout_s: float) -> bytes:
        until_s = self.now_s() + timeout_s
        while not msvcrt.kbhit():  # type: ignore[name-defined,unused-ignore]
            if self.now_s() >= until_s:
                return b""
            time.sleep(self.LOOK_S)
        return bytes(msvcrt.getch())  # type: ignore[name-defined,unused-ignore]


@contextlib.contextmanager
def raw_terminal() -> Iterator[RawTerminal]:
    """Take over the terminal of this process, and restore it at the end."""
    if sys.platform == "win32":
        yield _Console()
        return
    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)
    try:
        tty.setcbreak(number)  # Ctrl-C still ends the program
        yield RawTerminal()
    finally:
        termios.tcsetattr(number, termios.TCSAFLUSH, before)


# The examination: watch a held key.

# The user has this long for the first press.
PATIENCE_S = 20.0
# A gap of this length ends a press: it is longer than any delay before the first repeat.
OVER_S = 1.5
# A key that is held for longer has been measured long enough.
LONGEST_S = 15.0

# A control sequence, a function key of older terminals, Esc alone, or any other byte.
_KEY = re.compile(rb"\x1b\[[0-9;:?]*[ -/]*[@-~]|\x1bO[@-~]|\x1b(?=[^\[O])|[^\x1b]")


def examine(
    terminal: RawTerminal, environment: Mapping[str, str], tell: Callable[[str], None]
) -> Held:
    """Examine the keyboard of this terminal; `tell` shows the user what to do."""
    tell("Now hold the right arrow key for three seconds, then release it.")
    return held(_press(terminal), tmux="TMUX" in environment)


def _press(terminal: RawTerminal) -> list[float]:
    """Return the times of one long press: the events of its first key until a gap."""
    times_s: list[float] = []
    first = rest = b""
    until_s = terminal.now_s() + PATIENCE_S
    while (left_s := until_s - terminal.now_s()) > 0.0:
        rest += terminal.read(left_s)
        now_s = terminal.now_s()
        while (key := _KEY.match(rest)) is not None:
            rest = rest[key.end() :]  # a read may have cut the next one in two
            first = first or key[0]
            times_s += [now_s] * (key[0] == first)
        if times_s:
            until_s = min(times_s[-1] + OVER_S, times_s[0] + LONGEST_S)
    return times_s
