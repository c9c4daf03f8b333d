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
from typing import Any, Protocol

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

# Bytes from a terminal as what they mean: keys, and the terminal's answers to questions.

# Asks whether focus events are known (DECRQM).
ASK_FOCUS = b"\x1b[?1004$p"
# Asks whether key releases are reported (the kitty keyboard protocol); others stay silent.
ASK_RELEASES = b"\x1b[?u"
# Every terminal answers this; an earlier question without an answer will not get one.
ASK_END = b"\x1b[c"

_FOCUS = re.compile(rb"\x1b\[\?1004;(\d)\$y")
# Set, reset, and set for good: a mode that the terminal knows.
_KNOWN = (b"1", b"2", b"3")
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
    jog would end, `breaks` how often it would have ended while the key was held, and `dropped`
    whether the dead-man switch took the repeats for a backlog.
    """

    events: int
    delay_s: float | None = None
    interval_s: float | None = None
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

    def __str__(self) -> str:
        if self.delay_s is None or self.rate_hz is None:
            return f"{counted(self.events, 'event')} of the held key came"
        first = f"first repeat after {self.delay_s * 1e3:.0f} ms, then {self.rate_hz:.0f} a second"
        if self.released_s is None:
            return first
        return f"{first}. A release is noticed after {self.released_s * 1e3:.0f} ms"


def held(times_s: Sequence[float]) -> Held:
    """Measure one long press from the times of its events, the first press included."""
    gaps = [after - before for before, after in pairwise(times_s)]
    if not gaps:
        return Held(len(times_s))
    if len(gaps) <= FEWEST_REPEATS:
        return Held(len(times_s), gaps[0])
    switch = DeadMan()
    switch.arm(times_s[0] - QUIET_S)
    ends: list[float] = []
    dropped = False
    for time_s in (*times_s, math.inf):
        while (due_s := switch.next_s()) < time_s:
            ends += [due_s for each in switch.tick(due_s) if isinstance(each, Release)]
        if time_s < math.inf:
            actions = switch.press("held", time_s)
            ends += [time_s for each in actions if isinstance(each, Release)]
            dropped = dropped or any(isinstance(each, Disarm) for each in actions)
    breaks = [end_s for end_s in ends if end_s < times_s[-1]]
    released_s = None if len(breaks) == len(ends) else ends[len(breaks)] - times_s[-1]
    return Held(len(times_s), gaps[0], median(gaps[1:]), released_s, len(breaks), dropped)


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

# A terminal has this long to answer: over a slow link it needs it.
ANSWERS_S = 1.0

# The user has this long for the first press.
PATIENCE_S = 20.0

# A gap of this length ends a press: it is longer than any delay before the first repeat.
OVER_S = 1.5

# A key that is held for longer has been measured long enough.
LONGEST_S = 15.0


@dataclass(frozen=True, slots=True)
class Examined:
    """The results. `focus` is None if the terminal did not answer."""

    press: Held
    focus: bool | None
    releases: bool
    tmux: bool

    @property
    def works(self) -> bool:
        """Whether jogging by a held key will work here."""
        return self.press.works

    @property
    def remedies(self) -> list[str]:
        """The remedies, that of the worst problem first."""
        return [*self._of_press(), *self._of_terminal()]

    def _of_press(self) -> Iterator[str]:
        delay_s, interval_s = self.press.delay_s, self.press.interval_s
        if delay_s is None:
            yield (
                "the key did not repeat: switch key repeat on (X11: xset r on; macOS, for letters: "
                "defaults write -g ApplePressAndHoldEnabled -bool false, then a new login), or jog "
                "by single increments"
            )
        elif delay_s > REPEAT_WITHIN_S:
            yield (
                f"the first repeat came after {delay_s * 1e3:.0f} ms; a hold is recognised within "
                f"{REPEAT_WITHIN_S * 1e3:.0f} ms: set a shorter delay (X11: xset r rate 300 30; "
                "Windows, macOS and Wayland: in the keyboard settings)"
            )
        elif interval_s is None:
            yield "too few repeats came to measure their rate: hold the key longer"
        if self.press.dropped:
            yield (
                "repeats came in bursts, as over a link that stalls, and the dead-man switch "
                "dropped them: use a faster link, or jog by single increments"
            )
        elif self.press.breaks or (interval_s or 0.0) > SLOWEST_S:
            yield (
                "a late repeat ends the jog while the key is held: set a faster repeat, 20 to 30 a "
                "second, or use a faster link"
            )

    def _of_terminal(self) -> Iterator[str]:
        if not self.focus:
            yield (
                "tmux does not pass focus events on, or does not say: put `set -g focus-events on` "
                "into ~/.tmux.conf, so that a jog ends when you click elsewhere"
                if self.tmux
                else "this terminal may not report when its window loses the focus: then only the "
                "dead-man switch ends a held jog"
            )
        if self.tmux:
            yield (
                "tmux delays Esc by half a second unless ~/.tmux.conf has `set -s escape-time 10`; "
                "Space stops at once either way"
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
        releases = "can" if self.releases else "cannot"
        focus = {True: "can", False: "cannot", None: "did not say whether it can"}[self.focus]
        terminal = (
            f"Terminal{' (in tmux)' * self.tmux}: it {releases} report that a key is released; it "
            f"{focus} report that its window loses the focus."
        )
        return [
            f"Held key: {self.press}.",
            terminal,
            *(f"- {remedy}." for remedy in self.remedies),
            f"Verdict: {self.verdict}.",
        ]

    def view(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return {
            "held": asdict(self.press) | {"rate_hz": self.press.rate_hz},
            "focus_events": self.focus,
            "key_releases": self.releases,
            "tmux": self.tmux,
            "works": self.works,
            "verdict": self.verdict,
            "remedies": self.remedies,
        }


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
