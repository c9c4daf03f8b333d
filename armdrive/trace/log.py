"""The log: the entries of a flight recorder in words, one line for each entry.

A message that arrives in several pieces is described in the line of its last piece.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from armdrive.dialects.words import AnswerLines, Describer, answer, class_words
from armdrive.errors.table import code_of_name
from armdrive.registry import DIALECTS
from armdrive.status import code_of_reason
from armdrive.trace.entries import EntryKind, Since, Topic, TraceEntry
from armdrive.trace.files import Recording
from kinematics.text import counted

_PLAIN = Describer(lambda: AnswerLines(b"\r\n", answer), None)


def describer(dialect: str) -> Describer:
    """Return the describer of a dialect's messages; an unknown dialect's lines get no words."""
    row = DIALECTS.get(dialect)
    return _PLAIN if row is None else row.tools().talk


TEXT_AT = 34  # the column where the meaning of bytes begins, if the bytes are shorter

# The direction of bytes: to the arm, from the arm.
ARROWS: Mapping[EntryKind, str] = MappingProxyType({EntryKind.SENT: "->", EntryKind.RECEIVED: "<-"})


_CODED = re.compile(r"\[(E[0-9]{3})\] ")
_RAISED = re.compile(r"([A-Za-z_]+): ")
_REGISTERS = "; registers "
_NAMES_ITS_CLASS = frozenset((EntryKind.RAISED, EntryKind.LOST, EntryKind.FAILED))


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line. `number` counts entries since the connection, `time_s` the seconds since then.

    `shown` is the traffic as people write it (text, hexadecimal, or CAN frames), empty for other
    entries; `words` is its meaning; `code` is the error code, if one applies.
    """

    number: int
    time_s: float
    kind: EntryKind
    shown: str
    words: str
    code: str = ""

    @property
    def topic(self) -> Topic:
        """The topic of the line."""
        return self.kind.topic

    @property
    def arrow(self) -> str:
        """The direction of bytes; blank for other entries."""
        return ARROWS.get(self.kind, "  ")

    @property
    def columns(self) -> str:
        """The bytes and their meaning in two columns; for other entries, their text."""
        return f"{self.shown:<{TEXT_AT}}  {self.words}".rstrip() if self.shown else self.text

    def __str__(self) -> str:
        return f"{self.time_s:10.3f} s  {self.arrow} {self.columns}".rstrip()

    @property
    def text(self) -> str:
        """The words; preceded by the kind for entries without bytes."""
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
    """Puts entries into words, in order: a message may be spread over several entries.

    `began_s` is the arm's clock at the connection.
    """

    def __init__(self, dialect: str, began_s: float = 0.0) -> None:
        self._began_s = began_s
        self._describer = describer(dialect)
        self._splitter = self._describer.splitter()

    def line(self, number: int, entry: TraceEntry) -> LogLine:
        """Return the line of an entry."""
        time_s = entry.time_s - self._began_s
        if isinstance(entry.what, bytes):
            words = self._meaning(entry.kind, entry.what)
            return LogLine(number, time_s, entry.kind, self._describer.shown(entry.what), words)
        words = entry.what
        if entry.kind is EntryKind.REGISTERS:  # the entry repeats its counts: drop the first copy
            words = words.partition(_REGISTERS)[2] or words
        elif entry.kind is EntryKind.REQUEST:
            name, _, more = words.partition("(")
            words = " ".join((class_words(name), more.removesuffix(")"))).rstrip()
        return LogLine(number, time_s, entry.kind, "", words, _code(entry.kind, words))

    def _meaning(self, kind: EntryKind, data: bytes) -> str:
        """Return the meaning of bytes; of received bytes, that of the messages they complete."""
        talk = self._describer
        if kind is EntryKind.SENT:
            return talk.words(data, talk.sent)
        return "; ".join(talk.words(each.data, talk.received) for each in self._splitter.feed(data))

    def gap(self, number: int, time_s: float, missing: int) -> LogLine:
        """Return a line in place of entries that are no longer available.

        A message that began before them is discarded.
        """
        self._splitter = self._describer.splitter()
        words = f"{missing} older entries are no longer available"
        return LogLine(number, time_s - self._began_s, EntryKind.DROPPED, "", words)


def _code(kind: EntryKind, words: str) -> str:
    """Return the error code that applies to an entry's text, or an empty string."""
    coded = _CODED.match(words)
    if coded is not None:
        return coded[1]
    if kind is EntryKind.TRUST:
        return code_of_reason(words.partition(": ")[2])
    raised = _RAISED.match(words) if kind in _NAMES_ITS_CLASS else None
    return "" if raised is None else code_of_name(raised[1])


# A recording in words, with the first difference that a replay found.


def heading(recording: Recording) -> str:
    """Return one line that names the arm, the time and the reason of a recording."""
    header = recording.header
    span_s = recording.entries[-1].time_s - header.began_s if recording.entries else 0.0
    return (
        f"{header.arm} ({header.title}) on {header.link}, connected {header.began}, "
        f"{span_s:.1f} s, {counted(len(recording.entries), 'entry', 'entries')}, written: "
        f"{header.why}, "
        f"by armdrive {header.version}"
    )


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first difference between an arm and its simulated device during a replay.

    `arm` and `twin` are what each of them sent; `twin_state` is the simulated device's state then.
    """

    index: int
    time_s: float
    why: str
    arm: str
    twin: str
    twin_state: str
    twin_view: Mapping[str, object]

    def __str__(self) -> str:
        return (
            f"they differ at {self.time_s:.3f} s: {self.why}. The arm: {self.arm}. The simulated "
            f"device: {self.twin}. The simulated device's state: {self.twin_state}"
        )


def lines(
    recording: Recording, divergence: Divergence | None = None
) -> Iterator[tuple[float, str]]:
    """Yield the time and words of each entry, and the divergence after its entry."""
    for line in recorded(recording):
        yield line.time_s, str(line)
        if divergence is not None and divergence.index == line.number:
            yield line.time_s, f">>> {divergence}"


# Following a flight recorder: each read returns the new entries, and its cost is bounded.

LINES_AT_ONCE = 500  # lines made at once: about 25 ms on a small computer
FURTHEST_BEHIND = (
    2000  # a reader further behind skips the oldest entries; `armdrive record` writes them all
)


class LogReader:
    """A reading position in an arm's flight recorder; each `read` continues from there.

    A reader belongs to one thread. Several readers of one arm are independent.
    """

    def __init__(
        self, since: Since, dialect: str, began_s: float, *, back: int = FURTHEST_BEHIND
    ) -> None:
        self._since = since
        self._back = max(back, FURTHEST_BEHIND)
        self._next, _ = since(0, 0, back)
        self._missing_at_start = self._next if back else 0  # none are missed if none are wanted
        self._narrator = Narrator(dialect, began_s)

    def read(self, most: int = LINES_AT_ONCE) -> tuple[LogLine, ...]:
        """Return the new lines since the last call, the oldest first.

        At most `most` lines (and one that counts the skipped entries); the rest follows at the next
        call. Empty if there is nothing new.
        """
        first, entries = self._since(self._next, most, self._back)
        lines = []
        missing = first - self._next + self._missing_at_start
        if entries and missing:
            lines.append(self._narrator.gap(first - 1, entries[0].time_s, missing))
            self._missing_at_start = 0
        self._next = first + len(entries)
        lines += [self._narrator.line(first + index, each) for index, each in enumerate(entries)]
        return tuple(lines)


def recorded(recording: Recording) -> Iterator[LogLine]:
    """Yield the lines of a recording, from its first entry to its last."""
    header = recording.header
    narrator = Narrator(header.dialect, header.began_s)
    for number, entry in enumerate(recording.entries):
        yield narrator.line(number, entry)


# Which lines are wanted.

SEPARATOR = ","  # between search words that a line must all contain; the space bar stops the arm


@dataclass(frozen=True, slots=True)
class LogFilter:
    """The wanted topics, and words that a line must contain (in upper or lower case)."""

    topics: frozenset[Topic] = frozenset(Topic)
    text: str = ""

    def toggled(self, topic: Topic) -> LogFilter:
        """Return a filter with one topic switched on or off."""
        return replace(self, topics=self.topics ^ {topic})

    def passes(self, line: LogLine) -> bool:
        """Return whether the filter lets a line through."""
        if line.topic not in self.topics:
            return False
        searched = f"{line.text} {line.shown} {line.code}".lower()
        return all(word in searched for word in self.text.lower().split(SEPARATOR))
