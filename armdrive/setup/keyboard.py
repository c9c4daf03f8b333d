"""Bytes from a terminal as what they mean: keys, and the terminal's answers to questions.

Nothing here reads a terminal or a clock: bytes and the time of their arrival come in.
"""

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
from enum import Enum
from itertools import pairwise
from statistics import median
from typing import Protocol

from armdrive.motion.dead_man import (
    HOLD_INTERVALS,
    HOLD_LONGEST_S,
    HOLD_SHORTEST_S,
    REPEAT_WITHIN_S,
    Action,
    DeadMan,
    Disarm,
    Release,
)

if sys.platform != "win32":
    import termios
    import tty
else:
    import msvcrt

ASK_FOCUS = b"\x1b[?1004$p"
"""Asks whether focus events are known (DECRQM); the answer ends in a number of `_KNOWN`."""
ASK_RELEASES = b"\x1b[?u"
"""Asks whether key releases can be told (the kitty keyboard protocol); others stay silent."""
ASK_END = b"\x1b[c"
"""Every terminal answers this one: whatever has not been answered by then will not be."""

_FOCUS = re.compile(rb"\x1b\[\?1004;(\d)\$y")
_RELEASES = re.compile(rb"\x1b\[\?\d+u")
_END = re.compile(rb"\x1b\[\?[\d;]*c")
_KEY = re.compile(rb"\x1b\[[0-9;:?]*[ -/]*[@-~]|\x1bO[@-~]|\x1b(?=[^\[O])|[^\x1b]")
_KNOWN = {b"1", b"2", b"3"}
"""Set, reset, and set for good: a mode that the terminal knows."""


class TerminalAnswer(Enum):
    """What a terminal can say of itself."""

    FOCUS = "it tells when its window gains or loses the focus"
    NO_FOCUS = "it does not tell when its window loses the focus"
    RELEASES = "it can tell when a key is let go"
    END = "it has answered everything that it will"


@dataclass(frozen=True, slots=True)
class KeyArrival:
    """A key event, as bytes, and when it arrived."""

    text: bytes
    time_s: float


class Arrivals:
    """Takes bytes apart; a sequence that is cut in two by a read is put together again."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes, now_s: float) -> list[KeyArrival | TerminalAnswer]:
        """Return what these bytes complete, in order."""
        data, self._rest = self._rest + data, b""
        found: list[KeyArrival | TerminalAnswer] = []
        place = 0
        while place < len(data):
            match = _KEY.match(data, place)
            if match is None:
                self._rest = data[place:]  # the rest of it has not arrived
                break
            place = match.end()
            found.append(_answer(match[0]) or KeyArrival(match[0], now_s))
        return found


def _answer(sequence: bytes) -> TerminalAnswer | None:
    if focus := _FOCUS.fullmatch(sequence):
        return TerminalAnswer.FOCUS if focus[1] in _KNOWN else TerminalAnswer.NO_FOCUS
    if _RELEASES.fullmatch(sequence):
        return TerminalAnswer.RELEASES
    return TerminalAnswer.END if _END.fullmatch(sequence) else None


# Whether a key that is held can hold an arm: what the desk's dead-man would make of its repeats.
#
# The times at which a held key's events arrived come in; delay, rate, jitter and a verdict go out.
# The dead-man itself (motion/dead_man.py) is played the very same events, so that the verdict is
# not a guess.

TOGETHER_S = 0.004
"""Events nearer than this came in one piece: something on the way has kept them back."""

_FEWEST = 5
"""So many repeats are needed before anything can be said of their rate."""

NO_REPEAT = (
    "the key did not repeat: switch key repeat on (X11: xset r on; macOS, for letters: defaults "
    "write -g ApplePressAndHoldEnabled -bool false, then a new login), or jog by single increments"
)

_ABOUT = 1.05
_QUIET_S = 1.0
_HELD_KEY = "held"


@dataclass(frozen=True, slots=True)
class Held:
    """What was measured of one long press. Times in s; None where too few repeats came.

    `jitter_s` is how much longer than usual one repeat in twenty took, `longest_s` the longest
    silence between two, `together` the share of repeats that came in one piece with another.
    `released_s` is how long after the last repeat the jog would end, `breaks` how often it would
    have ended although the key was held, and `dropped` whether it was taken for backlog.
    """

    events: int
    delay_s: float | None = None
    interval_s: float | None = None
    jitter_s: float = 0.0
    longest_s: float = 0.0
    together: float = 0.0
    released_s: float | None = None
    breaks: int = 0
    dropped: bool = False

    @property
    def rate_hz(self) -> float | None:
        """Repeats a second."""
        return None if not self.interval_s else 1.0 / self.interval_s

    @property
    def works(self) -> bool:
        """Whether holding a key moves an arm smoothly here, and not longer than it is held."""
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
        together=sum(gap < TOGETHER_S for gap in gaps) / len(gaps),
        released_s=released_s,
        breaks=breaks,
        dropped=dropped,
    )


def _played(times_s: Sequence[float]) -> tuple[float | None, int, bool]:
    """Play the events to the dead-man: how long it holds on, how often it breaks, if it disarms."""
    man = DeadMan()
    man.arm(times_s[0] - _QUIET_S)
    ends: list[float] = []
    dropped = False
    for time_s in (*times_s, math.inf):
        heard: list[tuple[float, tuple[Action, ...]]] = []
        while (due_s := man.next_s()) < time_s:
            heard.append((due_s, man.tick(due_s)))
        if math.isfinite(time_s):
            heard.append((time_s, man.press(_HELD_KEY, time_s)))
        for now_s, actions in heard:
            ends += [now_s for action in actions if isinstance(action, Release)]
            dropped = dropped or any(isinstance(action, Disarm) for action in actions)
    after = [end_s for end_s in ends if end_s >= times_s[-1]]
    return (after[0] - times_s[-1] if after else None), len(ends) - len(after), dropped


def advice(found: Held) -> list[str]:
    """Say what keeps holding from working, in sentences, the worst first; none where it works."""
    if found.delay_s is None:
        return [NO_REPEAT]
    said = []
    if found.delay_s > REPEAT_WITHIN_S:
        said.append(
            f"the first repeat came after {found.delay_s * 1e3:.0f} ms; a hold is recognised "
            f"within {REPEAT_WITHIN_S * 1e3:.0f} ms: set a shorter delay (X11: xset r rate 300 30; "
            "Windows, macOS and Wayland: in the keyboard settings)"
        )
    if found.interval_s is None:
        said.append("too few repeats came to measure their rate: hold the key longer")
        return said
    slowest_s = HOLD_LONGEST_S / HOLD_INTERVALS
    if found.interval_s > slowest_s * _ABOUT:
        said.append(
            f"{1.0 / found.interval_s:.0f} repeats a second are few: below {1.0 / slowest_s:.0f} a "
            "late one already ends the jog. Set a faster repeat, 20 to 30 a second"
        )
    if found.dropped:
        said.append(
            "repeats came in heaps, as those of a link that stalls, and the dead-man dropped them: "
            "use a quicker link, or jog by single increments"
        )
    elif found.breaks:
        said.append(
            f"the jog would have ended {found.breaks} time(s) while the key was held, since "
            f"repeats came up to {found.longest_s * 1e3:.0f} ms apart: a faster repeat, or a "
            "quicker link"
        )
    return said


def sentence(found: Held) -> str:
    """Say in one line what was measured."""
    if found.delay_s is None or found.interval_s is None:
        return f"{found.events} event(s) of the held key came"
    hold_s = min(max(HOLD_INTERVALS * found.interval_s, HOLD_SHORTEST_S), HOLD_LONGEST_S)
    return (
        f"first repeat after {found.delay_s * 1e3:.0f} ms, then {1.0 / found.interval_s:.0f} a "
        f"second; one in twenty {found.jitter_s * 1e3:.0f} ms late, the longest gap "
        f"{found.longest_s * 1e3:.0f} ms, {found.together:.0%} together with another. Letting go "
        f"is noticed after {(found.released_s or hold_s) * 1e3:.0f} ms"
    )


# A terminal that hands over every byte as it comes, and is left as it was found.


class RawTerminal(Protocol):
    """A terminal whose keys are neither echoed nor gathered into lines."""

    def write(self, data: bytes) -> None:
        """Send bytes to it."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return what has come, after at most so long; b"" where nothing has."""
        ...

    def now_s(self) -> float:
        """Return the time on a clock that never goes back."""
        ...


@contextlib.contextmanager
def raw_terminal() -> Iterator[RawTerminal]:
    """Take over the terminal of this process, and give it back however this ends."""
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
    """Windows: keys come one by one, and a short sleep between looks loses no precision needed."""

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


# The examination of a keyboard: ask the terminal what it knows, then watch a key being held.

ANSWERS_S = 1.0
"""How long a terminal is waited for that does not answer at all: over a slow link it takes long."""

PATIENCE_S = 20.0
"""How long the first press is waited for."""

OVER_S = 1.5
"""So long a silence is the end of a press: longer than any delay before the first repeat."""

LONGEST_S = 15.0
UNEVEN_S = 0.06
"""A repeat in twenty that is later than this makes a link uneven."""


@dataclass(frozen=True, slots=True)
class Examined:
    """What was found. `focus` is None where the terminal did not answer."""

    press: Held
    focus: bool | None
    releases: bool
    tmux: bool
    screen: bool
    remote: bool

    @property
    def works(self) -> bool:
        """Whether jogging by holding a key will work here."""
        return self.press.works

    @property
    def remedies(self) -> list[str]:
        """What a person can do, the worst first."""
        said = advice(self.press)
        if not self.focus and self.tmux:
            said.append(
                "tmux keeps focus events to itself, or does not say: put `set -g focus-events "
                "on` into ~/.tmux.conf, so that a jog ends when you click elsewhere"
            )
        elif not self.focus:
            said.append(
                "this terminal does not say whether it tells when its window loses the focus: a "
                "held jog then ends by its dead-man alone"
                + (" (screen never tells; tmux does)" if self.screen else "")
            )
        if self.tmux:
            said.append(
                "in tmux, Esc is held back for half a second unless ~/.tmux.conf has `set -s "
                "escape-time 10`; Space stops at once either way"
            )
        if self.remote and self.press.jitter_s > UNEVEN_S:
            said.append(
                "over this link repeats come unevenly: single increments are the safer mode"
            )
        return said

    @property
    def verdict(self) -> str:
        """The answer in one sentence."""
        if self.works:
            return "holding a key to jog will work here"
        return "holding a key will not work here: jog by single increments, one press each"


def examine(
    terminal: RawTerminal, environment: Mapping[str, str], tell: Callable[[str], None]
) -> Examined:
    """Examine the keyboard of whoever sits at this terminal; `tell` says what to do."""
    answers = _ask(terminal)
    tell("Now hold the right arrow key for three seconds, then let go.")
    press = held(_press(terminal))
    focus = (
        True
        if TerminalAnswer.FOCUS in answers
        else False
        if TerminalAnswer.NO_FOCUS in answers
        else None
    )
    return Examined(
        press,
        focus,
        TerminalAnswer.RELEASES in answers,
        tmux="TMUX" in environment,
        screen="STY" in environment,
        remote="SSH_CONNECTION" in environment,
    )


def _ask(terminal: RawTerminal) -> set[TerminalAnswer]:
    """Ask the terminal what it knows; one that knows nothing says nothing."""
    arrivals, found = Arrivals(), set[TerminalAnswer]()
    terminal.write(ASK_FOCUS + ASK_RELEASES + ASK_END)
    until_s = terminal.now_s() + ANSWERS_S
    while TerminalAnswer.END not in found and terminal.now_s() < until_s:
        data = terminal.read(until_s - terminal.now_s())
        found |= {
            each
            for each in arrivals.feed(data, terminal.now_s())
            if isinstance(each, TerminalAnswer)
        }
    return found


def _press(terminal: RawTerminal) -> list[float]:
    """Return when the events of one long press came: those of its first key, until it is quiet."""
    arrivals = Arrivals()
    times_s: list[float] = []
    first = b""
    until_s = terminal.now_s() + PATIENCE_S
    while (left_s := until_s - terminal.now_s()) > 0.0:
        data = terminal.read(left_s)
        now_s = terminal.now_s()
        for each in arrivals.feed(data, now_s):
            if isinstance(each, KeyArrival) and (not first or each.text == first):
                first = each.text
                times_s.append(each.time_s)
        if times_s:
            until_s = min(times_s[-1] + OVER_S, times_s[0] + LONGEST_S)
    return times_s
