"""What every dialect needs to put its messages into words, and to compare them in a recording."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

from firmware_protocol.errors import ProtocolError
from firmware_protocol.lines import LineSplitter

Sentences: TypeAlias = Mapping[type, Callable[[Any], str]]
"""For each class of message, the sentence that says what it does."""

_SPLIT = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")

UNITS: Mapping[str, str] = {"rpm": "rpm", "ms": "ms", "ma": "mA", "steps": "steps"}
"""Endings of field names that are units, and how they are written."""


def plain(message: object) -> str:
    """Return a message as its name and its fields: `ReadEncoder()` is `read encoder`."""
    if isinstance(message, str):
        return str(message)
    if isinstance(message, Enum):
        return _name(message.name)
    if not is_dataclass(message):
        return str(message)
    said = (_field(each.name, getattr(message, each.name)) for each in fields(message))
    told = ", ".join(each for each in said if each)
    name = _SPLIT.sub(" ", type(message).__name__).lower()
    return f"{name}: {told}" if told else name


def wording(message: object, sentences: Sentences) -> str:
    """Return a message as its sentence, or in plain words where its class has none."""
    sentence = sentences.get(type(message))
    return plain(message) if sentence is None else sentence(message)


def moved(names: Sequence[str], counts: Sequence[int]) -> str:
    """Return relative counts by motor, those that are not zero: `base +37, shoulder -4`."""
    told = [f"{name} {count:+d}" for name, count in zip(names, counts, strict=False) if count]
    return ", ".join(told) or "no motor"


def standing(names: Sequence[str], counts: Iterable[int]) -> str:
    """Return absolute counts by motor, all of them: `base 37, shoulder 0`."""
    return ", ".join(f"{name} {count}" for name, count in zip(names, counts, strict=False))


def _field(name: str, value: object) -> str:
    """Return a field in words; nothing for one that was left out."""
    if value is None or value == () or value == "":
        return ""
    if name == "on":
        return "on" if value else "off"
    stem, _, last = name.rpartition("_")
    if stem and last in UNITS:
        return f"{_name(stem)} {_value(value)} {UNITS[last]}"
    return f"{_name(name)} {_value(value)}"


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Enum):
        return _name(value.name)
    if isinstance(value, bytes):
        return value.hex(" ")
    if isinstance(value, tuple):
        return " ".join(_value(each) for each in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _name(word: str) -> str:
    return word.replace("_", " ").lower()


# One message of a device in a recording, and how it is compared with its twin's.


class Weight(Enum):
    """How a message is compared."""

    ANSWER = "to the byte"
    MOMENT = "by its kind alone while motors turn, since it tells of a moment; else to the byte"
    PASSING = "not at all: how many there are, and when, is a matter of moments"
    SELF = "not at all: the device describes itself"
    BANNER = "that it comes, once the arm has told where it stands: a board that begins anew"


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a device; `kind` is what is compared where its numbers are of a moment."""

    data: bytes
    weight: Weight
    kind: bytes = b""


class Splitter(Protocol):
    """Messages out of bytes."""

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the messages that are whole by now."""


# How the bytes of one dialect are cut into messages and put into words.

LONGEST_LINE = 4096
MOST_LINES = 65536


class AnswerLines:
    """Messages that are lines."""

    def __init__(self, ends: bytes, weigh: Callable[[bytes], Message]) -> None:
        self._lines = LineSplitter(ends, max_length=LONGEST_LINE, max_lines=MOST_LINES)
        self._weigh = weigh

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the lines that have ended."""
        self._lines.feed(data)
        found = []
        while (line := self._lines.next_line()) is not None:
            data = line if isinstance(line, bytes) else line.start
            if data.strip():
                found.append(self._weigh(data.strip()))
        return found


def answer(line: bytes) -> Message:
    """Return a line as an answer, which is compared to the byte."""
    return Message(line, Weight.ANSWER)


def escaped(data: bytes) -> str:
    """Return bytes as text, with every control character escaped."""
    return data.decode("latin-1").encode("unicode_escape").decode("ascii")


@dataclass(frozen=True, slots=True, eq=False)
class Describer:
    """How one dialect is cut into messages and put into words.

    `sent` reads what a host writes at once, as a message or in words; `heard` reads one message;
    `shown` writes bytes for people. None where nothing is known of the dialect. `sentences` are
    for the messages whose plain words would not say what they do.
    """

    splitter: Callable[[], Splitter]
    heard: Callable[[bytes], object] | None
    sent: Callable[[bytes], object] | None = None
    shown: Callable[[bytes], str] = escaped
    sentences: Sentences = field(default_factory=lambda: MappingProxyType({}))

    def said(self, data: bytes) -> str:
        """Return one message for people, with its meaning where its bytes do not show it."""
        words = "" if self.shown is escaped else self.words(data, self.heard)
        return f"{self.shown(data)} ({words})" if words else self.shown(data)

    def words(self, data: bytes, read: Callable[[bytes], object] | None) -> str:
        """Return what bytes mean; nothing where that is not known."""
        try:
            return "" if read is None else self.wording(read(data))
        except ProtocolError:
            return "unreadable"

    def wording(self, message: object) -> str:
        """Return one message of this dialect in words; text is returned as it is."""
        return wording(message, self.sentences)
