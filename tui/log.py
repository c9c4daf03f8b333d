"""The log screen: what passes between the arm and the desk, in words, as it comes.

At each poll `LogView.read` takes at most a portion of new lines from the flight recorder. `LogBook`
keeps them and sieves them, `Folding` folds idle polling of what passes the sieve, and `Window`
chooses the lines in sight by their numbers, which do not change while others come and go.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import printable
from armdrive.errors.table import CatalogueEntry, by_code, found, in_full
from armdrive.status import Status
from armdrive.trace.entries import EntryKind, Topic
from armdrive.trace.log import LogBook, LogFilter, LogLine, LogReader
from kinematics.text import counted, folded
from tui.desk import Desk, DeskScreen
from tui.dialogs import TextDialog
from tui.keys.keyboard import Keyboard, bindings
from tui.widgets import panels

# Lines read at one poll, at most: 2000 a second. Reading them delays a stop by about 5 ms.
PORTION = 100


# The entries that idle polling of a resting arm repeats.
POLLING = frozenset((EntryKind.REQUEST, EntryKind.SENT, EntryKind.RECEIVED, EntryKind.REGISTERS))

# Distinct lines of one round of polling, at most: a bus of six drives needs forty.
REMEMBERED = 64

# Fewer repeated lines than this are shown as they are.
FOLDED_FROM = 8


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
    """Return the index of a line, or of the next one if it was dropped. `lines` is not empty."""
    at = bisect_left(lines, number, key=lambda line: line.number)
    return min(at, len(lines) - 1)


class LogView:
    """The log as it is read at a desk, and the keys that go through it."""

    def __init__(self, desk: Desk) -> None:
        self.book = LogBook()
        self.window = Window()
        self._desk = desk
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

    def read(self) -> None:
        """Read what is new."""
        try:
            if self._reader is None:
                self._reader = self._desk.arm.recorder.log()
            new = self._reader.read(PORTION)
        except ArmError as error:
            self._desk.message = str(error)
            return
        self.book.take(new)
        self._folding.take(filter(self.book.filter.passes, new), self.book.kept)

    def sieve(self, sieve: LogFilter) -> None:
        """Show other lines."""
        self.book.choose(sieve)
        self._folding = Folding()
        self._folding.take(self.book.lines, self.book.kept)

    def find(self, text: str) -> None:
        """Show only lines that contain a text."""
        self.sieve(LogFilter(self.book.filter.topics, text))
        self._desk.show()

    # -- keys ---------------------------------------------------------------------------------

    def switch_topic(self, topic: str) -> None:
        """Show a topic, or leave it out."""
        self.sieve(self.book.filter.toggled(Topic(topic)))

    def show_all(self) -> None:
        """Show everything again, and follow it."""
        self.follow()
        self.sieve(LogFilter())

    def switch_hold(self) -> None:
        """Hold the lines still, or follow the newest again."""
        if self.following:
            self.choose(self.line)
        else:
            self.follow()

    def go(self, by: int) -> None:
        """Choose another line."""
        self.window.go(self._lines, by)

    def turn_page(self, by: int) -> None:
        """Choose a line a page away."""
        self.go(by * max(self._height - 1, 1))

    def go_first(self) -> None:
        """Choose the oldest line."""
        self.go(-len(self._lines))

    def follow(self) -> None:
        """Follow the newest line again."""
        self.window = Window()

    def choose(self, line: LogLine | None) -> None:
        """Choose a line, which then stays in sight."""
        self.window.chosen = None if line is None else line.number


# Stands at the end of what did not fit; enter shows the whole line.
CUT = "~"

WAYS: Mapping[str, str] = {"->": "to the arm", "<-": "from the arm"}


def log_head(book: LogBook, keys: Keyboard, *, following: bool) -> str:
    """Return what is shown of how much, and by which keys that changes."""
    topics = "  ".join(
        f"{keys.label(f'log-{topic.value}')} [{'x' if topic in book.filter.topics else ' '}] "
        f"{topic.value}"
        for topic in Topic
    )
    conduct = "newest last" if following else "HELD STILL"
    text = f"  find: {book.filter.text}" if book.filter.text else ""
    return f"{topics}\n{conduct}, {len(book.lines)} of {counted(book.total, 'line')}{text}"


def log_row(line: LogLine, width: int, *, chosen: bool) -> str:
    """Return a line of the log cut to a width: mark, time, direction, code, bytes, words."""
    mark = ">" if chosen else "!" if line.topic is Topic.ERRORS else " "
    start = f"{mark}{line.time_s:10.3f} {line.arrow} "
    code = f"[{line.code}] " if line.code and not line.words.startswith("[") else ""
    if not line.shown:
        return cut(f"{start}{code}{line.text}", width)
    room = max((width - len(start)) * 2 // 5, 8)
    return cut(f"{start}{cut(line.shown, room):<{room}}  {line.words}", width)


def cut(text: str, width: int) -> str:
    """Return as much of a text as fits, with a sign where it was cut."""
    return text if len(text) <= width else f"{text[: max(width - 1, 0)]}{CUT}"


def whole_line(line: LogLine, width: int, keys: Keyboard) -> str:
    """Return everything that is known of a line; of an error the catalogue's row too."""
    way, row = WAYS.get(line.arrow, ""), by_code(line.code)
    parts = [
        f"{line.time_s:.4f} s after the connection, entry {line.number}: {line.kind.value} {way}",
        line.shown,
        line.words,
        *(() if row is None else in_full(row)),
    ]
    return "\n\n".join(_filled(keys.presented(part), width) for part in parts if part)


def catalogue_text(
    rows: Sequence[CatalogueEntry], at: int, width: int, height: int, keys: Keyboard
) -> str:
    """Return a list of errors with one chosen, and that one in full below it."""
    if not rows:
        return "no error contains these words"
    below = "\n".join(_filled(keys.presented(part), width) for part in in_full(rows[at]))
    room = max(height - below.count("\n") - 2, 1)
    first = min(max(at - room // 2, 0), max(len(rows) - room, 0))
    listed = (
        cut(f"{'>' if index == at else ' '} {each.code}  {each.title}", width)
        for index, each in enumerate(rows[first : first + room], first)
    )
    return "\n".join((*listed, "", below))


def asked_text(what: str, text: str) -> str:
    """Return the line in which a search is typed."""
    return f"{what}: {text}_   (commas between words; space stops the arm)"


def nothing_text(sieve: LogFilter) -> str:
    """Return why there is no line in sight."""
    missing = [topic.value for topic in Topic if topic not in sieve.topics]
    reasons = [f"left out: {', '.join(missing)}"] if missing else []
    reasons += [f"only with: {sieve.text}"] if sieve.text else []
    return f"no line ({'; '.join(reasons)})" if reasons else "nothing recorded yet"


def _filled(text: str, width: int) -> str:
    return "\n".join(folded(text, max(width, 20)))


# The dialogs: a line in full, the text that lines must have, and every error there is.


def line_dialog(keys: Keyboard, line: LogLine) -> TextDialog:
    """Return a dialog with one line in full, with cause and remedy where it is an error."""
    closes = f"{keys.label('close')} closes"
    return TextDialog(lambda width, _: f"{whole_line(line, width, keys)}\n\n{closes}")


def find_dialog(keys: Keyboard, view: LogView) -> TextDialog:
    """Return a dialog for the text that every line must have; the log follows as it is typed."""

    def words(*_: int) -> str:
        prompt = asked_text("only lines with", view.book.filter.text)
        return f"{prompt}\n{keys.label('close')}: done"

    return TextDialog(words, short=True, text=view.book.filter.text, typed=view.find)


class ErrorSearch:
    """Every error of the catalogue, found by words; the chosen one in full."""

    def __init__(self, keys: Keyboard, text: str = "") -> None:
        self._keys = keys
        self.find(text)

    def find(self, text: str) -> None:
        """Find the errors with this text."""
        self._text, self._rows, self._at = text, found(text), 0

    def choose(self, by: int) -> None:
        """Choose another error."""
        self._at = min(max(self._at + by, 0), max(len(self._rows) - 1, 0))

    def words(self, width: int, height: int) -> str:
        """Return what was typed, and the errors that were found."""
        head = f"{asked_text('errors with', self._text)}\n{self._keys.label('close')}: close\n"
        room = height - head.count("\n") - 1
        return f"{head}\n{catalogue_text(self._rows, self._at, width, room, self._keys)}"

    def dialog(self) -> TextDialog:
        """Return the dialog for it."""
        return TextDialog(self.words, text=self._text, typed=self.find, choose=self.choose)


# In addition to the marks and words that say the same.
STYLES = {Topic.ERRORS: "bold $text-error", Topic.CALLS: "bold", Topic.REQUESTS: "dim"}


class LogScreen(DeskScreen):
    """Shows, and moves nothing. What has come since the last poll is read, and no more."""

    place = "log"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        self.log_view = LogView(self.desk)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: what is shown of how much, and the lines."""
        with Vertical():
            yield from panels(**{"log-head": "What is shown", "log-lines": "Log"})

    def show_body(self, status: Status) -> None:  # noqa: ARG002 - the log says it itself
        """Take what has come, and show it."""
        view, keys = self.log_view, self.desk.keys
        view.read()
        self.text("log-head").show(log_head(view.book, keys, following=view.following))
        listed = self.text("log-lines")
        width, height = listed.content_size
        chosen = None if view.following else view.line
        rows = [
            (log_row(line, width, chosen=line is chosen), STYLES.get(line.topic, ""))
            for line in view.visible(height)
        ]
        if not rows:
            rows = [(nothing_text(view.book.filter), "")]
        # cut once more: an escape is longer than what it stands for
        listed.show_lines((printable(text)[: len(text)], style) for text, style in rows)

    # -- keys ---------------------------------------------------------------------------------

    def action_find(self) -> None:
        """Type what all lines must have."""
        self.desk.dialogs.open(find_dialog(self.desk.keys, self.log_view))

    def action_open_line(self) -> None:
        """Show all of the chosen line, or of the newest one."""
        line = self.log_view.line
        if line is None:
            raise BadRequest("there is no line to open")
        self.log_view.choose(line)
        self.desk.dialogs.open(line_dialog(self.desk.keys, line))

    def action_catalogue(self) -> None:
        """Show all errors."""
        line = self.log_view.line
        code = line.code if line is not None else ""
        self.desk.dialogs.open(ErrorSearch(self.desk.keys, code).dialog())

    def action_save(self) -> None:
        """Write the recording, and say where it is."""
        self.desk.say("writing ...")
        self.desk.calls.make(lambda: f"written: {self.desk.arm.recorder.save()}")
