"""Which lines of the log are in sight: the newest, or those around the one that was chosen."""

from __future__ import annotations

from bisect import bisect_left
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from armdrive.errors import ArmError
from armdrive.trace.entries import EntryKind, Topic
from armdrive.trace.log import LogBook, LogFilter, LogLine, LogReader
from tui.screens import ScreenHost

PORTION = 100
"""Lines read at one poll, at most: 2000 a second. Reading them delays a stop by about 5 ms."""


POLLING = frozenset((EntryKind.REQUEST, EntryKind.SENT, EntryKind.RECEIVED, EntryKind.REGISTERS))
"""What a program that asks a resting arm for its position repeats again and again."""

REMEMBERED = 64
"""Distinct lines of one round of polling, at most: a bus of six drives needs forty."""

FOLDED_FROM = 8
"""Fewer repeated lines than this are shown as they are."""


class Folding:
    """Lines in which idle polling is folded into one line that says how much it stands for.

    Polling is idle while it only repeats lines that have just been shown.
    """

    def __init__(self) -> None:
        self.lines: list[LogLine] = []
        """The lines as they are shown, the oldest first."""
        self._recent: OrderedDict[tuple[EntryKind, str, str], None] = OrderedDict()
        self._repeated: list[LogLine] = []
        self._folded = 0

    def take(self, lines: Iterable[LogLine], kept: int) -> None:
        """Take further lines, and keep no more than this many."""
        for line in lines:
            self._take(line)
        del self.lines[: max(len(self.lines) - kept, 0)]

    def _take(self, line: LogLine) -> None:
        key = (line.kind, line.shown, line.words)
        if line.kind not in POLLING or key not in self._recent:
            self._repeated, self._folded = [], 0
            self.lines.append(line)
        elif self._folded:
            self._folded += 1
            self.lines[-1] = self._fold(line)
        else:
            self._repeated.append(line)
            self.lines.append(line)
            if len(self._repeated) >= FOLDED_FROM:
                self._folded = len(self._repeated)
                self.lines[-self._folded :] = [self._fold(line)]
        self._recent[key] = None
        self._recent.move_to_end(key)
        if len(self._recent) > REMEMBERED:
            self._recent.popitem(last=False)

    def _fold(self, last: LogLine) -> LogLine:
        words = f"{self._folded} lines of idle polling, the same as above"
        return replace(self._repeated[0], time_s=last.time_s, shown="...", words=words)


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
        """Choose the line `by` lines further on; beyond the last one, follow the newest."""
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
        self._folding = Folding()
        self._height = 0

    @property
    def _lines(self) -> Sequence[LogLine]:
        return self._folding.lines

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
            self._folding.take(filter(self.book.filter.passes, new), self.book.kept)
        return bool(new)

    def sieve(self, sieve: LogFilter) -> None:
        """Have other lines in sight."""
        self.book.choose(sieve)
        self._folding = Folding()
        self._folding.take(self.book.lines, self.book.kept)
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
