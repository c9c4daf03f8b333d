"""What happens to an arm and on its wire, in words: a line for each entry of a recorder.

An entry becomes one line. A message that came in several pieces is told at the piece that ends it.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from armdrive.dialects.words import AnswerLines, Describer, answer
from armdrive.errors.table import code_of_name
from armdrive.registry import DIALECTS
from armdrive.status import code_of_reason
from armdrive.trace.entries import TOPICS, EntryKind, Topic, TraceEntry
from armdrive.trace.files import Recording

# What passes on the wire in words, as the row of its dialect in the registry states it.

_PLAIN = Describer(lambda: AnswerLines(b"\r\n", answer), None)


def talk(dialect: str) -> Describer:
    """Return how a dialect is put into words; of an unknown one, lines without words."""
    row = DIALECTS.get(dialect)
    return _PLAIN if row is None else row.tools().talk


TEXT_AT = 34
"""The column where the meaning of bytes begins, where the bytes are shorter."""

ARROWS: Mapping[EntryKind, str] = MappingProxyType({EntryKind.SENT: "->", EntryKind.HEARD: "<-"})
"""Which way bytes went: to the arm, from the arm."""


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

    @property
    def what(self) -> str:
        """The bytes and what they mean, in two columns; of other lines, what they tell."""
        return f"{self.shown:<{TEXT_AT}}  {self.words}".rstrip() if self.shown else self.told

    def __str__(self) -> str:
        return f"{self.time_s:10.3f} s  {self.way} {self.what}".rstrip()

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
    """Puts entries into words, one after another: a message may come in several pieces.

    `began_s` is the arm's clock at the connection.
    """

    def __init__(self, dialect: str, began_s: float = 0.0) -> None:
        self._began_s = began_s
        self._talk = talk(dialect)
        self._splitter = self._talk.splitter()

    def line(self, number: int, entry: TraceEntry) -> LogLine:
        """Return the line of an entry."""
        time_s = entry.time_s - self._began_s
        if isinstance(entry.what, bytes):
            words = self._meaning(entry.kind, entry.what)
            return LogLine(number, time_s, entry.kind, self._talk.shown(entry.what), words)
        words = entry.what
        if entry.kind is EntryKind.REGISTERS:  # its counts stand there twice
            words = words.partition(_TWICE)[2] or words
        return LogLine(number, time_s, entry.kind, "", words, _code(entry.kind, words))

    def _meaning(self, kind: EntryKind, data: bytes) -> str:
        """Return what bytes mean: of what is heard, the messages that they complete."""
        if kind is EntryKind.SENT:
            return self._talk.words(data, self._talk.sent)
        heard = self._splitter.feed(data)
        return "; ".join(self._talk.words(each.data, self._talk.heard) for each in heard)

    def text(self, entry: TraceEntry) -> str:
        """Return an entry in a line of its own, with the arm's clock and all that was noted."""
        line = self.line(0, entry)
        noted = f"{entry.kind.value}: {entry.what!s}"
        what = line.what if isinstance(entry.what, bytes) else noted
        return f"{entry.time_s:12.4f} s  {line.way} {what}"

    def view(self, entry: TraceEntry) -> dict[str, Any]:
        """Return an entry as plain data, the bytes in hexadecimal."""
        view: dict[str, Any] = {"time_s": entry.time_s, "kind": entry.kind.value}
        if not isinstance(entry.what, bytes):
            return view | {"text": entry.what}
        line = self.line(0, entry)
        return view | {"hex": entry.what.hex(), "text": line.shown, "words": line.words}

    def gap(self, number: int, time_s: float, missing: int) -> LogLine:
        """Return the line that stands for entries that nobody can tell any more.

        A message that had begun before them is forgotten.
        """
        self._splitter = self._talk.splitter()
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


# A recording for people: one line an entry, and where a replay has parted from it.


def heading(recording: Recording) -> str:
    """Say whose recording it is, when it was made, and why."""
    header = recording.header
    span_s = recording.entries[-1].time_s - header.began_s if recording.entries else 0.0
    return (
        f"{header.arm} ({header.title}) on {header.link}, connected {header.began}, "
        f"{span_s:.1f} s, {len(recording.entries)} entries, written: {header.why}, "
        f"by armdrive {header.version}"
    )


@dataclass(frozen=True, slots=True)
class Parting:
    """The first difference: at which entry, what each said, and how the twin stands then."""

    index: int
    time_s: float
    why: str
    arm: str
    twin: str
    twin_state: str
    twin_view: Mapping[str, object]

    def __str__(self) -> str:
        return (
            f"they part at {self.time_s:.3f} s: {self.why}. The arm: {self.arm}. The twin: "
            f"{self.twin}. The twin stands like this: {self.twin_state}"
        )


def lines(recording: Recording, parting: Parting | None = None) -> Iterator[tuple[float, str]]:
    """Return each entry's time and words, and the parting where it came."""
    narrator = Narrator(recording.header.dialect)
    for index, entry in enumerate(recording.entries):
        yield entry.time_s, narrator.text(entry)
        if parting is not None and parting.index == index:
            yield entry.time_s, f">>> {parting}"


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
