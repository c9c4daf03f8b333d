"""Which lines of the log are in sight: the newest, or those around the one that was chosen."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.trace.log import LogLine


@dataclass(slots=True)
class Window:
    """A window over lines that grow at one end and go at the other; lines go by their numbers.

    `chosen` and `top` are numbers of lines: what is looked at stays where it is while others come.
    Without a chosen line the newest is followed.
    """

    chosen: int | None = None
    top: int = 0

    def visible(self, lines: Sequence[LogLine], height: int) -> Sequence[LogLine]:
        """Return the lines in sight, no more than `height`, with the chosen one among them."""
        last = max(len(lines) - height, 0)
        if self.chosen is None or not lines:
            first = last
        else:
            at = index_of(lines, self.chosen)
            self.chosen = lines[at].number
            first = min(max(index_of(lines, self.top), at - height + 1), at, last)
        self.top = lines[first].number if lines else 0
        return lines[first : first + height]

    def go(self, lines: Sequence[LogLine], by: int) -> None:
        """Choose another line, so many further on; beyond the last one the newest is followed."""
        if not lines:
            return
        at = len(lines) - 1 if self.chosen is None else index_of(lines, self.chosen)
        if self.chosen is None and by >= 0:
            return
        at += by
        self.chosen = None if at >= len(lines) else lines[max(at, 0)].number

    def line(self, lines: Sequence[LogLine]) -> LogLine | None:
        """Return the chosen line, or the newest; None where there is none."""
        if not lines:
            return None
        return lines[-1] if self.chosen is None else lines[index_of(lines, self.chosen)]


def index_of(lines: Sequence[LogLine], number: int) -> int:
    """Return where a line is, or the next one after it where it has gone; lines must be there."""
    at = bisect_left(lines, number, key=lambda line: line.number)
    return min(at, len(lines) - 1)
