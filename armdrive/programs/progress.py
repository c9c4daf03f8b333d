"""How far a run has come, where it is, and how long it still takes.

`RunProgress` estimates that from the rehearsal; a `RunView` follows a run and gives its view as
plain data, which `armdrive run`, the shell, the desk and `armdrive status` all show. Units: s on
the arm's clock.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.arm import Arm
from armdrive.programs.acts import RunStep
from armdrive.programs.problems import SourceLines, SourceMark

# The number of loops that means endless.
FOR_EVER = 0

# The second loop begins where the first ended, and so do all others.
LOOPS_REHEARSED = 2


@dataclass(frozen=True, slots=True)
class Took:
    """How long one act of a rehearsal took, and its place in the program."""

    mark: SourceMark
    what: str
    took_s: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """How far a run has come. `percent` and `left_s` are None if unknown.

    For an endless run both are those of the present loop.
    """

    percent: float | None = None
    left_s: float | None = None


UNKNOWN = Estimate()


class RunProgress:
    """Follows a run along its rehearsal, act by act.

    `loops` are the rehearsed loops, the last of which stands for all later ones; `repeated` is how
    many loops the run has, or `FOR_EVER`. Without a rehearsed loop nothing is known. A run that
    takes another path than its rehearsal, by an input that comes, makes the estimate worse.
    """

    def __init__(self, loops: Sequence[Sequence[Took]], *, repeated: int = 1) -> None:
        self._loops = [[each.took_s for each in loop] for loop in loops]
        self._repeated = repeated
        self._loop = 0
        self._index = 0

    @property
    def total_s(self) -> float | None:
        """How long the whole run takes; None if it is endless or unknown."""
        if self._repeated == FOR_EVER or not self._loops:
            return None
        return self._first_s(self._repeated)

    def begins(self, loop: int = 1) -> None:
        """Note that the next act of a loop begins."""
        self._index = self._index + 1 if loop == self._loop else 0
        self._loop = loop

    def estimate(self, under_way_s: float, share: float = 1.0) -> Estimate:
        """Return how far the run has come, `under_way_s` after the present act began.

        `share` is the present speed as a share of the rehearsed speed.
        """
        if not (self._loop and self._loops):
            return UNKNOWN
        loop = self._loops[min(self._loop, len(self._loops)) - 1]
        took_s = loop[self._index] if self._index < len(loop) else 0.0
        done_s = sum(loop[: self._index]) + min(under_way_s * share, took_s)
        whole_s = sum(loop)
        if self._repeated != FOR_EVER:
            done_s += self._first_s(self._loop - 1)
            whole_s = self._first_s(self._repeated)
        percent = 100.0 * done_s / whole_s if whole_s > 0.0 else 0.0
        return Estimate(percent, max(whole_s - done_s, 0.0) / share)

    def _first_s(self, loops: int) -> float:
        """Return how long the first loops take: a person may ask for millions of them."""
        later = max(loops - len(self._loops), 0)
        return sum(map(sum, self._loops[:loops])) + later * sum(self._loops[-1])


# Where a running program is: for the terminal, the desk, and other programs that ask.


class RunView:
    """Follows one run. `lines` are those of the program.

    Every method may be called from any thread.
    """

    def __init__(self, lines: SourceLines) -> None:
        self.step: RunStep | None = None
        """The act under way; None before the first one."""
        self._lines = lines
        self._progress = RunProgress(())
        self._share = 1.0
        self._loops = 1
        self._began_s = 0.0
        self._lock = threading.RLock()

    def follow(self, progress: RunProgress, *, share: float = 1.0, loops: int = 1) -> None:
        """Estimate by a rehearsal in which the arm moved with `share` of its speed."""
        with self._lock:
            self._progress, self._share, self._loops = progress, share, loops

    def use(self, arm: Arm) -> None:
        """Let other programs ask this arm for the view."""
        arm.program = self.view

    def at(self, step: RunStep) -> None:
        """Note where the program is, and what it waits for."""
        with self._lock:
            self.step = step
            self._progress.begins(step.loop)
            self._began_s = step.arm.parts.pace.now_s()

    def line_at(self, mark: SourceMark) -> str:
        """Return the line at a mark, "" if there is none."""
        return self._lines.get((mark.file, mark.line), "").strip()

    @property
    def under_way_s(self) -> float:
        """How long the present act has taken so far, on the arm's clock."""
        return 0.0 if self.step is None else self.step.arm.parts.pace.now_s() - self._began_s

    def view(self) -> dict[str, Any]:
        """Return where the program is, as plain data; empty before its first act."""
        with self._lock:
            step = self.step
            if step is None:
                return {}
            share = step.arm.speed_override / self._share
            estimate = self._progress.estimate(self.under_way_s, share)
            return {
                "file": step.mark.file,
                "line": step.mark.line or None,
                "column": step.mark.column,
                "text": self.line_at(step.mark),
                "act": step.name,
                "waiting": step.waiting or None,
                "loop": step.loop,
                "loops": self._loops,
                "percent": None if estimate.percent is None else round(estimate.percent, 1),
                "left_s": None if estimate.left_s is None else round(estimate.left_s, 1),
            }


# A running program's position and times as text.

# A line without its comment; no match if it has none.
_SAID = re.compile(r"""(?:"[^"]*"|'[^']*'|[^"'#])*(?=#)""")


def place_words(view: Mapping[str, Any]) -> str:
    """Return where a program is, as a line for people."""
    percent, left_s = view["percent"], view["left_s"]
    share = "    " if percent is None else f"{percent:3.0f}%"
    left = "" if left_s is None else f"  {duration(left_s)} left"
    loop = "" if view["loops"] == 1 else f"loop {view['loop']}  "
    waiting = f"  {view['waiting']}" if view["waiting"] else ""
    line = line_words(view["line"], view["text"] or view["act"])
    return f"{share}  {loop}{line}{waiting}{left}"


def line_words(line: int | None, text: str) -> str:
    """Return a line of a program with its number, if it is known, and without its comment."""
    said = _SAID.match(text)
    text = said.group().rstrip() if said else text
    return f"line {line}: {text}" if line else text


def duration(time_s: float) -> str:
    """Return a time for people: seconds, or minutes and seconds, or hours and minutes."""
    if time_s < 60.0:
        return f"{time_s:.1f} s" if time_s < 10.0 else f"{time_s:.0f} s"
    minutes, seconds = divmod(round(time_s), 60)
    if minutes < 60:
        return f"{minutes} min {seconds} s"
    return f"{minutes // 60} h {minutes % 60} min"
