"""The examination of a keyboard: ask the terminal what it knows, then watch a key being held."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from armdrive.keyboard.arrivals import ASK_END, ASK_FOCUS, ASK_RELEASES, Answer, Arrivals, Key
from armdrive.keyboard.holding import Held, advice, held
from armdrive.keyboard.terminal import Terminal

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
    terminal: Terminal, environment: Mapping[str, str], tell: Callable[[str], None]
) -> Examined:
    """Examine the keyboard of whoever sits at this terminal; `tell` says what to do."""
    answers = _ask(terminal)
    tell("Now hold the right arrow key for three seconds, then let go.")
    press = held(_press(terminal))
    focus = True if Answer.FOCUS in answers else False if Answer.NO_FOCUS in answers else None
    return Examined(
        press,
        focus,
        Answer.RELEASES in answers,
        tmux="TMUX" in environment,
        screen="STY" in environment,
        remote="SSH_CONNECTION" in environment,
    )


def _ask(terminal: Terminal) -> set[Answer]:
    """Ask the terminal what it knows; one that knows nothing says nothing."""
    arrivals, found = Arrivals(), set[Answer]()
    terminal.write(ASK_FOCUS + ASK_RELEASES + ASK_END)
    until_s = terminal.now_s() + ANSWERS_S
    while Answer.END not in found and terminal.now_s() < until_s:
        data = terminal.read(until_s - terminal.now_s())
        found |= {
            each for each in arrivals.feed(data, terminal.now_s()) if isinstance(each, Answer)
        }
    return found


def _press(terminal: Terminal) -> list[float]:
    """Return when the events of one long press came: those of its first key, until it is quiet."""
    arrivals = Arrivals()
    times_s: list[float] = []
    first = b""
    until_s = terminal.now_s() + PATIENCE_S
    while (left_s := until_s - terminal.now_s()) > 0.0:
        data = terminal.read(left_s)
        now_s = terminal.now_s()
        for each in arrivals.feed(data, now_s):
            if isinstance(each, Key) and (not first or each.text == first):
                first = each.text
                times_s.append(each.time_s)
        if times_s:
            until_s = min(times_s[-1] + OVER_S, times_s[0] + LONGEST_S)
    return times_s
