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
from dataclasses import dataclass
from itertools import pairwise
from statistics import median
from typing import Protocol

from armdrive.motion.dead_man import (
    HOLD_INTERVALS,
    HOLD_LONGEST_S,
    REPEAT_WITHIN_S,
    Action,
    DeadMan,
    Disarm,
    Release,
    hold_s,
)
from kinematics.text import counted

if sys.platform != "win32":
    import termios
    import tty
else:
    import msvcrt

# Bytes from a terminal as what they mean: keys, and the terminal's answers to questions.

ASK_FOCUS = b"\x1b[?1004$p"
"""Asks whether focus events are known (DECRQM)."""
ASK_RELEASES = b"\x1b[?u"
"""Asks whether key releases are reported (the kitty keyboard protocol); others stay silent."""
ASK_END = b"\x1b[c"
"""Every terminal answers this; an earlier question without an answer will not get one."""

_FOCUS = re.compile(rb"\x1b\[\?1004;(\d)\$y")
_KNOWN = (b"1", b"2", b"3")
"""Set, reset, and set for good: a mode that the terminal knows."""
_RELEASES = re.compile(rb"\x1b\[\?\d+u")
_END = re.compile(rb"\x1b\[\?[\d;]*c")
_ANSWER = re.compile(rb"\x1b\[\?[\d;]*(?:\$y|u|c)")
# a control sequence, a function key of older terminals, Esc alone, or any other byte
_KEY = re.compile(rb"\x1b\[[0-9;:?]*[ -/]*[@-~]|\x1bO[@-~]|\x1b(?=[^\[O])|[^\x1b]")


class KeyEvents:
    """Splits bytes into key events and answers, also if a read cuts one in two."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the events that these bytes complete, in order."""
        data, self._rest = self._rest + data, b""
        found: list[bytes] = []
        place = 0
        while place < len(data):
            match = _KEY.match(data, place)
            if match is None:
                self._rest = data[place:]  # the rest of it has not arrived
                break
            place = match.end()
            found.append(match[0])
        return found


# Whether a held key can keep an arm moving: how the desk's dead-man switch treats its repeats.
#
# From the times of the events follow the delay, the rate, the jitter and a verdict. The verdict is
# no guess: the dead-man switch itself (motion/dead_man.py) gets the same events.

_FEWEST = 5
"""The fewest repeats from which a rate can be measured."""

NO_REPEAT = (
    "the key did not repeat: switch key repeat on (X11: xset r on; macOS, for letters: defaults "
    "write -g ApplePressAndHoldEnabled -bool false, then a new login), or jog by single increments"
)

_ABOUT = 1.05
"""A measured rate that is so little too slow is no fault."""
_QUIET_S = 1.0
"""The dead-man switch is armed this long before the first press, as in a desk that is open."""
_HELD_KEY = "held"


@dataclass(frozen=True, slots=True)
class Held:
    """The measurements of one long press; None if too few repeats came.

    `jitter_s` is how much longer than usual one repeat in twenty took, and `longest_s` the longest
    gap between two. `released_s` is how long after the last repeat the jog would end, `breaks` how
    often it would have ended while the key was held, and `dropped` whether the dead-man switch took
    the repeats for a backlog.
    """

    events: int
    delay_s: float | None = None
    interval_s: float | None = None
    jitter_s: float = 0.0
    longest_s: float = 0.0
    released_s: float | None = None
    breaks: int = 0
    dropped: bool = False

    @property
    def rate_hz(self) -> float | None:
        """The repeats per second."""
        return None if not self.interval_s else 1.0 / self.interval_s

    @property
    def works(self) -> bool:
        """Whether holding a key moves an arm smoothly, and only while the key is held."""
        return self.interval_s is not None and not self.breaks and not self.dropped


def held(times_s: Sequence[float]) -> Held:
    """Measure one long press from the times of its events, the first press included."""
    if len(times_s) < 2:
        return Held(len(times_s))
    delay_s = times_s[1] - times_s[0]
    gaps = [after - before for before, after in pairwise(times_s[1:])]
    if len(gaps) < _FEWEST:
        return Held(len(times_s), delay_s)
    usual_s = median(gaps)
    late = sorted(gaps)[min(math.ceil(0.95 * len(gaps)), len(gaps) - 1)]
    released_s, breaks, dropped = _played(times_s)
    return Held(
        events=len(times_s),
        delay_s=delay_s,
        interval_s=usual_s,
        jitter_s=late - usual_s,
        longest_s=max(gaps),
        released_s=released_s,
        breaks=breaks,
        dropped=dropped,
    )


def _played(times_s: Sequence[float]) -> tuple[float | None, int, bool]:
    """Feed the events to the dead-man switch; return its release time, breaks, and disarming."""
    man = DeadMan()
    man.arm(times_s[0] - _QUIET_S)
    ends: list[float] = []
    dropped = False
    for time_s in (*times_s, math.inf):
        acted: list[tuple[float, tuple[Action, ...]]] = []
        while (due_s := man.next_s()) < time_s:
            acted.append((due_s, man.tick(due_s)))
        if math.isfinite(time_s):
            acted.append((time_s, man.press(_HELD_KEY, time_s)))
        for now_s, actions in acted:
            ends += [now_s for action in actions if isinstance(action, Release)]
            dropped = dropped or any(isinstance(action, Disarm) for action in actions)
    after = [end_s for end_s in ends if end_s >= times_s[-1]]
    return (after[0] - times_s[-1] if after else None), len(ends) - len(after), dropped


def advice(found: Held) -> list[str]:
    """Return what keeps a held key from working, the worst first; nothing if it works."""
    if found.delay_s is None:
        return [NO_REPEAT]
    faults = []
    if found.delay_s > REPEAT_WITHIN_S:
        faults.append(
            f"the first repeat came after {found.delay_s * 1e3:.0f} ms; a hold is recognised "
            f"within {REPEAT_WITHIN_S * 1e3:.0f} ms: set a shorter delay (X11: xset r rate 300 30; "
            "Windows, macOS and Wayland: in the keyboard settings)"
        )
    if found.interval_s is None:
        faults.append("too few repeats came to measure their rate: hold the key longer")
        return faults
    slowest_s = HOLD_LONGEST_S / HOLD_INTERVALS
    if found.interval_s > slowest_s * _ABOUT:
        faults.append(
            f"{1.0 / found.interval_s:.0f} repeats a second are few: below {1.0 / slowest_s:.0f} a "
            "late one already ends the jog. Set a faster repeat, 20 to 30 a second"
        )
    if found.dropped:
        faults.append(
            "repeats came in bursts, as over a link that stalls, and the dead-man switch dropped "
            "them: use a faster link, or jog by single increments"
        )
    elif found.breaks:
        faults.append(
            f"the jog would have ended {counted(found.breaks, 'time')} while the key was "
            "held, since "
            f"repeats came up to {found.longest_s * 1e3:.0f} ms apart: set a faster repeat, or use "
            "a faster link"
        )
    return faults


def sentence(found: Held) -> str:
    """Return the measurements in one line."""
    if found.delay_s is None or found.interval_s is None:
        return f"{counted(found.events, 'event')} of the held key came"
    return (
        f"first repeat after {found.delay_s * 1e3:.0f} ms, then {1.0 / found.interval_s:.0f} a "
        f"second; one in twenty {found.jitter_s * 1e3:.0f} ms late, the longest gap "
        f"{found.longest_s * 1e3:.0f} ms. A release is noticed after "
        f"{(found.released_s or hold_s(found.interval_s)) * 1e3:.0f} ms"
    )


# A terminal that passes on every byte at once, and is restored afterwards.


class RawTerminal(Protocol):
    """A terminal that neither echoes keys nor collects them into lines."""

    def write(self, data: bytes) -> None:
        """Send bytes to the terminal."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return the bytes that have come, waiting for at most `timeout_s`."""
        ...

    def now_s(self) -> float:
        """Return the time of a monotonic clock."""
        ...


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
        yield _Tty(number)
    finally:
        termios.tcsetattr(number, termios.TCSAFLUSH, before)


class _Tty:
    def __init__(self, number: int) -> None:
        self._number = number

    def write(self, data: bytes) -> None:
        sys.stdout.flush()
        os.write(sys.stdout.fileno(), data)

    def read(self, timeout_s: float) -> bytes:
        ready, _, _ = select.select([self._number], [], [], timeout_s)
        return os.read(self._number, 4096) if ready else b""

    def now_s(self) -> float:
        return time.monotonic()


class _Console:
    """Windows: keys come one by one; a short sleep between looks is precise enough."""

    LOOK_S = 0.002

    def write(self, data: bytes) -> None:
        sys.stdout.write(data.decode("ascii"))
        sys.stdout.flush()

    def read(self, timeout_s: float) -> bytes:
        until_s = self.now_s() + timeout_s
        while not msvcrt.kbhit():  # type: ignore[name-defined,unused-ignore]
            if self.now_s() >= until_s:
                return b""
            time.sleep(self.LOOK_S)
        return bytes(msvcrt.getch())  # type: ignore[name-defined,unused-ignore]

    def now_s(self) -> float:
        return time.perf_counter()


# The examination: ask the terminal what it supports, then watch a held key.

ANSWERS_S = 1.0
"""A terminal has this long to answer: over a slow link it needs it."""

PATIENCE_S = 20.0
"""The user has this long for the first press."""

OVER_S = 1.5
"""A gap of this length ends a press: it is longer than any delay before the first repeat."""

LONGEST_S = 15.0
"""A key that is held for longer has been measured long enough."""

UNEVEN_S = 0.06
"""A link is uneven if one repeat in twenty is later than this."""


@dataclass(frozen=True, slots=True)
class Examined:
    """The results. `focus` is None if the terminal did not answer."""

    press: Held
    focus: bool | None
    releases: bool
    tmux: bool
    screen: bool
    remote: bool

    @property
    def works(self) -> bool:
        """Whether jogging by a held key will work here."""
        return self.press.works

    @property
    def remedies(self) -> list[str]:
        """The remedies, that of the worst problem first."""
        remedies = advice(self.press)
        if not self.focus and self.tmux:
            remedies.append(
                "tmux does not pass focus events on, or does not say: put `set -g focus-events on` "
                "into ~/.tmux.conf, so that a jog ends when you click elsewhere"
            )
        elif not self.focus:
            remedies.append(
                "this terminal may not report when its window loses the focus: then only the "
                "dead-man switch ends a held jog"
                + (" (screen never reports it; tmux does)" if self.screen else "")
            )
        if self.tmux:
            remedies.append(
                "tmux delays Esc by half a second unless ~/.tmux.conf has `set -s "
                "escape-time 10`; Space stops at once either way"
            )
        if self.remote and self.press.jitter_s > UNEVEN_S:
            remedies.append("repeats come unevenly over this link: single increments are safer")
        return remedies

    @property
    def verdict(self) -> str:
        """The verdict in one sentence."""
        if self.works:
            return "holding a key to jog will work here"
        return "holding a key will not work here: jog by single increments, one press each"


def examine(
    terminal: RawTerminal, environment: Mapping[str, str], tell: Callable[[str], None]
) -> Examined:
    """Examine the keyboard of this terminal; `tell` shows the user what to do."""
    answers = _ask(terminal)
    tell("Now hold the right arrow key for three seconds, then release it.")
    press = held(_press(terminal))
    focus = _FOCUS.search(answers)
    return Examined(
        press,
        None if focus is None else focus[1] in _KNOWN,
        _RELEASES.search(answers) is not None,
        tmux="TMUX" in environment,
        screen="STY" in environment,
        remote="SSH_CONNECTION" in environment,
    )


def _ask(terminal: RawTerminal) -> bytes:
    """Return what the terminal answers, nothing if it is silent."""
    answers = b""
    terminal.write(ASK_FOCUS + ASK_RELEASES + ASK_END)
    until_s = terminal.now_s() + ANSWERS_S
    while not _END.search(answers) and terminal.now_s() < until_s:
        answers += terminal.read(until_s - terminal.now_s())
    return answers


def _press(terminal: RawTerminal) -> list[float]:
    """Return the times of one long press: the events of its first key until a gap."""
    events = KeyEvents()
    times_s: list[float] = []
    first = b""
    until_s = terminal.now_s() + PATIENCE_S
    while (left_s := until_s - terminal.now_s()) > 0.0:
        data = terminal.read(left_s)
        now_s = terminal.now_s()
        for event in events.feed(data):
            if event == (first or event) and not _ANSWER.fullmatch(event):
                first = event
                times_s.append(now_s)
        if times_s:
            until_s = min(times_s[-1] + OVER_S, times_s[0] + LONGEST_S)
    return times_s
