"""One line of the log: when, which way, what, and what it means; made of a recorder's entries.

An entry becomes one line. A message that came in several pieces is told at the piece that ends it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Any

from armdrive.catalogue import code_of_class, code_of_reason
from armdrive.recorder.entries import Entry, Kind
from armdrive.recorder.timeline import ARROWS, TEXT_AT, Teller


class Topic(StrEnum):
    """What a line is about: people choose by it what they want to see."""

    BYTES = "bytes"
    REQUESTS = "requests"
    INTENTS = "intents"
    STATES = "states"
    ERRORS = "errors"


TOPICS: Mapping[Kind, Topic] = MappingProxyType(
    {
        Kind.SENT: Topic.BYTES,
        Kind.HEARD: Topic.BYTES,
        Kind.CALL: Topic.INTENTS,
        Kind.RAISED: Topic.ERRORS,
        Kind.REQUEST: Topic.REQUESTS,
        Kind.REGISTERS: Topic.REQUESTS,
        Kind.REPLY: Topic.REQUESTS,
        Kind.SILENCE: Topic.ERRORS,
        Kind.ALERT: Topic.ERRORS,
        Kind.ODDITY: Topic.ERRORS,
        Kind.STATE: Topic.STATES,
        Kind.OFFSET: Topic.STATES,
        Kind.TRUST: Topic.STATES,
        Kind.CURRENT: Topic.STATES,
        Kind.NOTICE: Topic.ERRORS,
        Kind.ERROR: Topic.ERRORS,
        Kind.STOP: Topic.INTENTS,
        Kind.LOST: Topic.ERRORS,
        Kind.FAILED: Topic.ERRORS,
        Kind.GAP: Topic.STATES,
    }
)
"""The topic of each kind of entry."""

_CODED = re.compile(r"\[(E[0-9]{3})\] ")
_RAISED = re.compile(r"([A-Za-z_]+): ")
_TWICE = "; registers "
_OF_CLASSES = frozenset((Kind.RAISED, Kind.LOST, Kind.FAILED))


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line. `number` counts entries from the connection on, `time_s` the seconds since then.

    `shown` is bytes as people write them (as text, in hexadecimal, or as CAN frames), empty where
    nothing passed on the wire; `words` say what it means; `code` is the catalogue's, if one fits.
    """

    number: int
    time_s: float
    kind: Kind
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

    def line(self, number: int, entry: Entry) -> LogLine:
        """Return the line of an entry."""
        time_s = entry.time_s - self._began_s
        if isinstance(entry.what, bytes):
            shown, words = self._teller.shown(entry), self._teller.meaning(entry)
            return LogLine(number, time_s, entry.kind, shown, words)
        words = entry.what
        if entry.kind is Kind.REGISTERS:  # the counts stand there twice: for replays, for people
            words = words.partition(_TWICE)[2] or words
        return LogLine(number, time_s, entry.kind, "", words, _code(entry.kind, words))

    def gap(self, number: int, time_s: float, missing: int) -> LogLine:
        """Return the line that stands for entries that nobody can tell any more.

        A message that had begun before them is forgotten.
        """
        self._teller = Teller(self._dialect)
        words = f"{missing} entries before this are not shown: they are too old"
        return LogLine(number, time_s - self._began_s, Kind.GAP, "", words)


def _code(kind: Kind, words: str) -> str:
    """Return the code of the catalogue that a sentence belongs to; empty where none does."""
    coded = _CODED.match(words)
    if coded is not None:
        return coded[1]
    if kind is Kind.TRUST:
        return code_of_reason(words.partition(": ")[2])
    raised = _RAISED.match(words) if kind in _OF_CLASSES else None
    return "" if raised is None else code_of_class(raised[1])
