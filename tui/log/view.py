"""Which lines of the log are in sight: the newest, or those around the one that was chosen."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armdrive.errors import ArmError
from armdrive.trace.entries import Topic
from armdrive.trace.log import LogBook, LogFilter, LogLine, LogReader
from tui.screens import ScreenHost

PORTION = 100
"""So many lines are made at a poll, which is 2000 a second, and keeps a stop waiting some 5 ms."""


@dataclass(slots=True)
class Window:
    """A window over lines that grow at one end and go at the other; lines go by their numbers.

    `chosen` and `top` are numbers of lines: what is looked at stays where it is while others come.
    Without a chosen line the newest is followed.
    """

    chosen: int | None = None
    top: int = 0

    def visible(self, lines: Sequence[LogLine], height: int) -> Sequence[LogLine]:
        """Return the lines in sight, no more than `height`, with the chosen one among them.

        None are in sight of a screen that has not been laid out yet.
        """
        if height <= 0:
            return lines[:0]
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


class LogView:
    """The log as it is read at a desk, and the keys that go through it."""

    def __init__(self, desk: ScreenHost, changed: Callable[[], None]) -> None:
        """`changed` is called when a key has changed what is in sight."""
        self.book = LogBook()
        self.window = Window()
        self.held = False
        """Whether the lines are held still."""
        self._desk = desk
        self._changed = changed
        self._reader: LogReader | None = None
        self._lines: Sequence[LogLine] = ()
        self._height = 0

    @property
    def following(self) -> bool:
        """Whether the newest line is followed."""
        return self.window.chosen is None

    @property
    def line(self) -> LogLine | None:
        """The chosen line, or the newest; None where there is none."""
        return self.window.line(self._lines)

    def visible(self, height: int) -> Sequence[LogLine]:
        """Return the lines in sight, no more than `height`."""
        self._height = height
        return self.window.visible(self._lines, height)

    def read(self) -> bool:
        """Read what is new, unless held still; return whether there was anything."""
        if self.held:
            return False
        try:
            if self._reader is None:
                self._reader = self._desk.arm.log()
            new = self._reader.read(PORTION)
        except ArmError as error:
            self._desk.message = str(error)
            return False
        if new:
            self.book.take(new)
            self._lines = tuple(self.book.lines)
        return bool(new)

    def sieve(self, sieve: LogFilter) -> None:
        """Have other lines in sight."""
        self.book.choose(sieve)
        self._lines = tuple(self.book.lines)
        self._changed()

    def find(self, text: str) -> None:
        """Have only lines with a text in sight."""
        self.sieve(LogFilter(self.book.filter.topics, text))

    # -- keys ---------------------------------------------------------------------------------

    def switch_topic(self, topic: str) -> None:
        """Show a topic, or leave it out."""
        self.sieve(self.book.filter.toggled(Topic(topic)))

    def show_all(self) -> None:
        """Show everything again, and follow it."""
        self.held = False
        self.window = Window()
        self.sieve(LogFilter())

    def switch_hold(self) -> None:
        """Hold the lines still, or let them come again."""
        self.held = not self.held
        self._changed()

    def go(self, by: int) -> None:
        """Choose another line."""
        self.window.go(self._lines, by)
        self._changed()

    def turn_page(self, by: int) -> None:
        """Choose a line a page away."""
        self.go(by * max(self._height - 1, 1))

    def go_first(self) -> None:
        """Choose the oldest line."""
        self.go(-len(self._lines))

    def follow(self) -> None:
        """Follow the newest line again."""
        self.window = Window()
        self._changed()

    def choose(self, line: LogLine) -> None:
        """Choose a line, which then stays in sight."""
        self.window.chosen = line.number
