"""One line of the log: when, which way, what, and what it means; made of a recorder's entries.

An entry becomes one line. A message that came in several pieces is told at the piece that ends it.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from armdrive.errors.table import code_of_name
from armdrive.status import code_of_reason
from armdrive.trace.entries import TOPICS, EntryKind, Topic, TraceEntry
from armdrive.trace.files import Recording
from armdrive.trace.timeline import ARROWS, TEXT_AT, Teller

_CODED = re.compile(r"\[(E[0-9]{3})\] ")
_RAISED = re.compile(r"([A-Za-z_]+): ")
_TWICE = "; registers "
_OF_CLASSES = frozenset((EntryKind.RAISED, EntryKind.LOST, EntryKind.FAILED))


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line. `number` counts entries from the connection on, `time_s` the seconds since then.

    `shown` is bytes as people write them (as text, in hexadecimal, or as CAN frames), empty where
    nothing passed on the wire; `words` say what it means; `code` is the catalogue's, if one fits.
    """

    number: int
    time_s: float
    kind: EntryKind
    shown: str
    words: str
    code: str = ""

    @property
    def topic(self) -> Topic:
        """What the line is about."""
        return TOPICS[self.kind]

    @property
    def way(self) -> str:
        """The arrow of bytes: to the arm, or from it."""
        return ARROWS.get(self.kind, "  ")

    def __str__(self) -> str:
        what = f"{self.shown:<{TEXT_AT}}  {self.words}" if self.shown else self.told
        return f"{self.time_s:10.3f} s  {self.way} {what}".rstrip()

    @property
    def told(self) -> str:
        """The words with what they are, for lines without bytes."""
        return self.words if self.shown else f"{self.kind.value}: {self.words}"

    def view(self) -> dict[str, Any]:
        """Return the line as plain data."""
        return {
            "number": self.number,
            "time_s": round(self.time_s, 6),
            "kind": self.kind.value,
            "topic": self.topic.value,
            "shown": self.shown,
            "words": self.words,
            "code": self.code,
        }


class Narrator:
    """Makes lines of entries, one after another; `began_s` is the arm's clock at the connection."""

    def __init__(self, dialect: str, began_s: float) -> None:
        self._dialect = dialect
        self._began_s = began_s
        self._teller = Teller(dialect)

    def line(self, number: int, entry: TraceEntry) -> LogLine:
        """Return the line of an entry."""
        time_s = entry.time_s - self._began_s
        if isinstance(entry.what, bytes):
            shown, words = self._teller.shown(entry), self._teller.meaning(entry)
            return LogLine(number, time_s, entry.kind, shown, words)
        words = entry.what
        if (
            entry.kind is EntryKind.REGISTERS
        ):  # the counts stand there twice: for replays, for people
            words = words.partition(_TWICE)[2] or words
        return LogLine(number, time_s, entry.kind, "", words, _code(entry.kind, words))

    def gap(self, number: int, time_s: float, missing: int) -> LogLine:
        """Return the line that stands for entries that nobody can tell any more.

        A message that had begun before them is forgotten.
        """
        self._teller = Teller(self._dialect)
        words = f"{missing} entries before this are not shown: they are too old"
        return LogLine(number, time_s - self._began_s, EntryKind.GAP, "", words)


def _code(kind: EntryKind, words: str) -> str:
    """Return the code of the catalogue that a sentence belongs to; empty where none does."""
    coded = _CODED.match(words)
    if coded is not None:
        return coded[1]
    if kind is EntryKind.TRUST:
        return code_of_reason(words.partition(": ")[2])
    raised = _RAISED.match(words) if kind in _OF_CLASSES else None
    return "" if raised is None else code_of_name(raised[1])


# Reading a flight recorder as it fills: only what has come since the last time, and bounded.

Since = Callable[[int, int, int], tuple[int, tuple[TraceEntry, ...]]]
"""A number, how many at most, and how far back at most: as `EntryRing.since`."""

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


# Which lines of a log somebody wants to see, and the latest of them, kept within a bound.

KEPT = 2000
"""So many lines are kept to be looked at; the oldest go."""
BETWEEN = ","
"""Stands between words that have all to be in a line: the space bar stops the arm."""


@dataclass(frozen=True, slots=True)
class Sieve:
    """Topics that are wanted, and a text that every line must have (no matter its capitals)."""

    topics: frozenset[Topic] = frozenset(Topic)
    text: str = ""

    def turned(self, topic: Topic) -> Sieve:
        """Return a sieve with one topic more, or less."""
        return replace(self, topics=self.topics ^ {topic})

    def passes(self, line: LogLine) -> bool:
        """Tell whether a line is wanted."""
        if line.topic not in self.topics:
            return False
        said = f"{line.told} {line.shown} {line.code}".lower()
        return all(part in said for part in self.text.lower().split(BETWEEN))


class LogBook:
    """The latest lines, and those of them that pass. What a new line costs is bounded."""

    def __init__(self, kept: int = KEPT) -> None:
        self.sieve = Sieve()
        self._all: deque[LogLine] = deque(maxlen=kept)
        self._passed: deque[LogLine] = deque(maxlen=kept)
        self.kept = kept

    @property
    def lines(self) -> deque[LogLine]:
        """The lines that pass, the oldest first."""
        return self._passed

    @property
    def total(self) -> int:
        """How many lines there are, passed or not."""
        return len(self._all)

    def take(self, lines: Iterable[LogLine]) -> int:
        """Take new lines; return how many of them pass."""
        before = 0
        for line in lines:
            self._all.append(line)
            if self.sieve.passes(line):
                self._passed.append(line)
                before += 1
        oldest = self._all[0].number if self._all else 0
        while self._passed and self._passed[0].number < oldest:
            self._passed.popleft()
        return before

    def choose(self, sieve: Sieve) -> None:
        """Have other lines pass."""
        self.sieve = sieve
        self._passed = deque(filter(sieve.passes, self._all), maxlen=self.kept)

    def clear(self) -> None:
        """Forget all lines; those to come are not touched."""
        self._all.clear()
        self._passed.clear()
