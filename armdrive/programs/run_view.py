"""Where a running program is: for the terminal, the desk, and other programs that ask.

One `RunView` follows a run and gives its view as plain data; `place_words` makes a line of text of
that. `armdrive run`, the shell, the desk and `armdrive status` all show this view.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Mapping
from typing import Any

from armdrive.arm import Arm
from armdrive.programs.acts import RunStep
from armdrive.programs.arm_access import time_s
from armdrive.programs.problems import SourceLines, SourceMark
from armdrive.programs.progress import Estimate, RunProgress


class RunView:
    """Follows one run. `lines` are those of the program.

    Every method may be called from any thread.
    """

    def __init__(self, lines: SourceLines) -> None:
        self.arm: Arm | None = None
        self.mark: SourceMark | None = None
        self.act = ""
        self._lines = lines
        self._progress = RunProgress(())
        self._share = 1.0
        self._waiting = ""
        self._loop = 1
        self._loops = 1
        self._began_s = 0.0
        self._lock = threading.RLock()

    def follow(self, progress: RunProgress, *, share: float = 1.0, loops: int = 1) -> None:
        """Estimate by a rehearsal in which the arm moved with `share` of its speed."""
        with self._lock:
            self._progress, self._share, self._loops = progress, share, loops

    def use(self, arm: Arm) -> None:
        """Take the time from this arm, and let other programs ask it for this view."""
        with self._lock:
            self.arm = arm
        arm.program = self.view

    def at(self, step: RunStep) -> None:
        """Note where the program is, and what it waits for."""
        with self._lock:
            self.arm, self.mark, self.act = step.arm, step.mark, step.name
            self._loop, self._waiting = step.loop, step.waiting
            self._progress.begins(step.mark, step.loop)
            self._began_s = time_s(step.arm)

    def line_at(self, mark: SourceMark) -> str:
        """Return the line at a mark, "" if there is none."""
        return self._lines.get((mark.file, mark.line), "").strip()

    @property
    def under_way_s(self) -> float:
        """How long the present act has taken so far, on the arm's clock."""
        return 0.0 if self.arm is None else time_s(self.arm) - self._began_s

    def view(self) -> dict[str, Any]:
        """Return where the program is, as plain data; empty before its first act."""
        with self._lock:
            if self.mark is None:
                return {}
            estimate = self._estimate()
            return {
                "file": self.mark.file,
                "line": self.mark.line or None,
                "column": self.mark.column,
                "text": self.line_at(self.mark),
                "act": self.act,
                "waiting": self._waiting or None,
                "loop": self._loop,
                "loops": self._loops,
                "percent": None if estimate.percent is None else round(estimate.percent, 1),
                "left_s": None if estimate.left_s is None else round(estimate.left_s, 1),
            }

    def _estimate(self) -> Estimate:
        if self.arm is None:
            return Estimate()
        return self._progress.estimate(self.under_way_s, self.arm.speed_override / self._share)


# A running program's position and times as text.

_SAID = re.compile(r"""(?:"[^"]*"|'[^']*'|[^"'#])*(?=#)""")
"""A line without its comment; no match if it has none."""


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
