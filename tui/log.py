"""The log screen: what passes between the arm and the desk, in words, as it comes.

At each poll `LogScreen` takes at most a portion of new lines from the flight recorder. `Folding`
folds idle polling of what passes the filter. The chosen line goes by its number, which does not
change while others come and go.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import OrderedDict, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import printable
from armdrive.errors.table import by_code, in_full
from armdrive.status import Status
from armdrive.trace.entries import EntryKind, Topic
from armdrive.trace.log import LogFilter, LogLine, LogReader
from kinematics.text import counted, folded
from tui.desk import DeskScreen
from tui.dialogs import TextDialog
from tui.keys.keyboard import Keyboard, bindings
from tui.keys.table import STOP
from tui.widgets import panels

# Lines read at one poll, at most: 2000 a second. Reading them delays a stop by about 5 ms.
PORTION = 100

# The log shows the last lines, no more than this number.
LINES_KEPT = 2000


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

    def take(self, lines: Iterable[LogLine]) -> None:
        """Take further lines, and drop the oldest of too many."""
        for line in lines:
            self._take(line)
        del self.lines[: max(len(self.lines) - LINES_KEPT, 0)]

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


def index_of(lines: Sequence[LogLine], number: int | None) -> int:
    """Return the index of a line, or of the next one if it was dropped; None means the newest."""
    at = len(lines) if number is None else bisect_left(lines, number, key=lambda each: each.number)
    return min(at, len(lines) - 1)


def in_sight(lines: Sequence[LogLine], at: int, height: int) -> Sequence[LogLine]:
    """Return no more than `height` lines, of which this one is the last if there are enough."""
    first = max(at + 1 - height, 0)
    return lines[first : first + max(height, 0)]


# Stands at the end of what did not fit; enter shows the whole line.
CUT = "~"

WAYS: Mapping[str, str] = {"->": "to the arm", "<-": "from the arm"}


def log_head(sieve: LogFilter, keys: Keyboard, rows: int, lines: int, *, following: bool) -> str:
    """Return what is shown of how much, and by which keys that changes."""
    topics = "  ".join(
        f"{keys.label(f'log-{topic.value}')} [{'x' if topic in sieve.topics else ' '}] "
        f"{topic.value}"
        for topic in Topic
    )
    conduct = "newest last" if following else "HELD STILL"
    text = f"  find: {sieve.text}" if sieve.text else ""
    return f"{topics}\n{conduct}, {counted(rows, 'row')} of {counted(lines, 'line')}{text}"


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


def nothing_text(sieve: LogFilter) -> str:
    """Return why there is no line in sight."""
    missing = [topic.value for topic in Topic if topic not in sieve.topics]
    reasons = [f"left out: {', '.join(missing)}"] if missing else []
    reasons += [f"only with: {sieve.text}"] if sieve.text else []
    return f"no line ({'; '.join(reasons)})" if reasons else "nothing recorded yet"


def _filled(text: str, width: int) -> str:
    return "\n".join(folded(text, max(width, 20)))


# In addition to the marks and words that say the same.
STYLES = {Topic.ERRORS: "bold $text-error", Topic.CALLS: "bold", Topic.REQUESTS: "dim"}


class LogScreen(DeskScreen):
    """Shows, and moves nothing. What has come since the last poll is read, and no more."""

    place = "log"
    go = "log-open"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        self.filter = LogFilter()
        self._all: deque[LogLine] = deque(maxlen=LINES_KEPT)
        self.chosen: int | None = None
        """The number of the chosen line, which stays in sight; None to follow the newest."""
        self._reader: LogReader | None = None
        self._folding = Folding()

    @property
    def lines(self) -> Sequence[LogLine]:
        """The lines that pass the filter, with idle polling folded."""
        return self._folding.lines

    @property
    def line(self) -> LogLine | None:
        """The chosen line, or the newest; None where there is none."""
        return self.lines[index_of(self.lines, self.chosen)] if self.lines else None

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: what is shown of how much, and the lines."""
        with Vertical():
            yield from panels(**{"log-head": "What is shown", "log-lines": "Log"})

    def show_body(self, status: Status) -> None:  # noqa: ARG002 - the log says it itself
        """Take what has come, and show it."""
        self._read()
        rows, lines, following = len(self.lines), len(self._all), self.chosen is None
        head = log_head(self.filter, self.desk.keys, rows, lines, following=following)
        self.text("log-head").show(head)
        listed = self.text("log-lines")
        width, height = listed.content_size
        chosen = None if self.chosen is None else self.line
        shown = [
            (log_row(line, width, chosen=line is chosen), STYLES.get(line.topic, ""))
            for line in in_sight(self.lines, index_of(self.lines, self.chosen), height)
        ]
        if not shown:
            shown = [(nothing_text(self.filter), "")]
        # cut once more: an escape is longer than what it stands for
        listed.show_lines((printable(text)[: len(text)], style) for text, style in shown)

    def _read(self) -> None:
        """Read what is new."""
        try:
            if self._reader is None:
                self._reader = self.desk.arm.recorder.log()
            new = self._reader.read(PORTION)
        except ArmError as error:
            self.desk.message = str(error)
            return
        self._all += new
        self._folding.take(filter(self.filter.passes, new))

    def sieve(self, sieve: LogFilter) -> None:
        """Show other lines."""
        self.filter, self._folding = sieve, Folding()
        self._folding.take(filter(sieve.passes, self._all))

    # -- keys ---------------------------------------------------------------------------------

    def action_choose(self, by: int) -> None:
        """Choose another line; beyond the last one, follow the newest."""
        at = index_of(self.lines, self.chosen) + by
        if self.lines:
            self.chosen = self.lines[max(at, 0)].number if at < len(self.lines) else None

    def action_turn_page(self, by: int) -> None:
        """Choose a line a page away."""
        self.action_choose(by * max(self.text("log-lines").content_size.height - 1, 1))

    def action_go_first(self) -> None:
        """Choose the oldest line."""
        self.action_choose(-len(self.lines))

    def action_follow(self) -> None:
        """Follow the newest line again."""
        self.chosen = None

    def action_switch_hold(self) -> None:
        """Hold the lines still, or follow the newest again."""
        line = self.line
        self.chosen = line.number if line is not None and self.chosen is None else None

    def action_switch_topic(self, topic: str) -> None:
        """Show a topic, or leave it out."""
        self.sieve(self.filter.toggled(Topic(topic)))

    def action_show_all(self) -> None:
        """Show everything again, and follow it."""
        self.action_follow()
        self.sieve(LogFilter())

    def action_find(self) -> None:
        """Type what all lines must have; the log follows as it is typed."""
        keys = self.desk.keys

        def words(_: int) -> str:
            prompt = f"only lines with: {self.filter.text}_"
            return (
                f"{prompt}   (commas between words; {keys.label(STOP)} stops the arm)\n"
                f"{keys.label('close')}: done"
            )

        def find(text: str) -> None:
            self.sieve(LogFilter(self.filter.topics, text))
            self.desk.show()

        self.desk.open_dialog(TextDialog(words, short=True, text=self.filter.text, typed=find))

    def action_open_line(self) -> None:
        """Show all of the chosen line, or of the newest one: of an error, cause and remedy too."""
        line, keys = self.line, self.desk.keys
        if line is None:
            raise BadRequest("there is no line to open")
        self.chosen = line.number
        closes = f"{keys.label('close')} closes"
        self.desk.open_dialog(
            TextDialog(lambda width: f"{whole_line(line, width, keys)}\n\n{closes}")
        )

    def action_save(self) -> None:
        """Write the recording, and say where it is."""
        self.desk.say("writing ...")
        self.desk.calls.make(lambda: f"written: {self.desk.arm.recorder.save()}")
