"""Whether a key that is held can hold an arm: what the desk's dead-man would make of its repeats.

The times at which a held key's events arrived come in; delay, rate, jitter and a verdict go out.
The dead-man itself (jog.py) is played the very same events, so that the verdict is not a guess.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

from armdrive.jog import (
    HOLD_INTERVALS,
    HOLD_LONGEST_S,
    HOLD_SHORTEST_S,
    REPEAT_WITHIN_S,
    Action,
    DeadMan,
    Disarm,
    Release,
)

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
_KEY = "held"


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
            heard.append((time_s, man.press(_KEY, time_s)))
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
