"""Reading a flight recorder as it fills: only what has come since the last time, and bounded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from armdrive.log.lines import LogLine, Narrator
from armdrive.recorder.entries import Entry

if TYPE_CHECKING:
    from armdrive.recorder.reading import Recording

Since = Callable[[int, int, int], tuple[int, tuple[Entry, ...]]]
"""A number, how many at most, and how far back at most: as `Ring.since`."""

MOST = 500
"""So many lines are made at once: some 25 ms of a small computer."""
BACK = 2000
"""Nobody reads further back on a screen; `armdrive record` writes everything. A reader that has
not read for longer than so many entries passes over the oldest of them, and says so."""


class LogReader:
    """A place in what an arm's flight recorder holds. Each `read` goes on from there.

    One reader is for one thread; several readers of one arm do not disturb each other.
    """

    def __init__(self, since: Since, dialect: str, began_s: float, *, back: int = BACK) -> None:
        self._since = since
        self._back = max(back, BACK)
        self._next, _ = since(0, 0, back)
        self._untold = self._next if back else 0  # who asks for nothing old is told of none
        self._narrator = Narrator(dialect, began_s)

    def read(self, most: int = MOST) -> tuple[LogLine, ...]:
        """Return the lines that have come since the last call, the oldest first.

        At most so many of them (and one that says how many were passed over); the rest comes with
        the next call. Empty where nothing has come.
        """
        first, entries = self._since(self._next, most, self._back)
        lines = []
        missing = first - self._next + self._untold
        if entries and missing:
            lines.append(self._narrator.gap(first - 1, entries[0].time_s, missing))
            self._untold = 0
        self._next = first + len(entries)
        lines += [self._narrator.line(first + index, each) for index, each in enumerate(entries)]
        return tuple(lines)


def recorded(recording: Recording) -> Iterator[LogLine]:
    """Yield the lines of a recording, from its first entry to its last."""
    header = recording.header
    narrator = Narrator(header.dialect, header.began_s)
    for number, entry in enumerate(recording.entries):
        yield narrator.line(number, entry)
