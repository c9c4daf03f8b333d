"""Describe a dialect's messages in words, and compare them in a recording."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

from firmware_protocol.errors import ProtocolError
from firmware_protocol.events import Unreadable, UnreadableFrame
from firmware_protocol.fields import in_words
from firmware_protocol.frames import Frame
from firmware_protocol.lines import LineSplitter
from kinematics.text import shown_name

# A sentence for each class of messages.
Sentences: TypeAlias = Mapping[type, Callable[[Any], str]]

_SPLIT = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")

# Suffixes of field names that are units, and their notation.
UNITS: Mapping[str, str] = {
    "rpm": "rpm", "ms": "ms", "ma": "mA", "steps": "steps", "deg": "deg", "mm": "mm", "s": "s",
    "n": "N",
}  # fmt: skip


def plain(message: object) -> str:
    """Return a message's name and fields: `SetCurrent(800)` is `set current: 800 mA`.

    A value that has words of its own, as a pose has, is left to say them.
    """
    if isinstance(message, str | Frame):
        return str(message)
    if isinstance(message, UnreadableFrame):
        return f"unreadable frame: {message.frame}: {message.reason}"
    if isinstance(message, Unreadable):
        return f"unreadable: `{escaped(message.data)}`: {message.reason}"
    if isinstance(message, Enum):
        return in_words(message)
    if not is_dataclass(message) or type(message).__str__ is not object.__str__:
        return str(message)
    name = class_words(type(message).__name__)
    parts = (named(each.name, getattr(message, each.name), name) for each in fields(message))
    values = ", ".join(filter(None, parts))
    return f"{name}: {values}" if values else name


def class_words(name: str) -> str:
    """Return the name of a class as words: `SetCurrent` is `set current`."""
    return _SPLIT.sub(" ", name).lower()


def wording(message: object, sentences: Sentences) -> str:
    """Return a message's sentence, or its plain words if its class has none."""
    sentence = sentences.get(type(message))
    return plain(message) if sentence is None else sentence(message)


def moved(names: Sequence[str], counts: Sequence[int]) -> str:
    """Return relative counts by motor, those that are not zero: `base +37, shoulder -4`."""
    moving = [f"{name} {count:+d}" for name, count in zip(names, counts, strict=False) if count]
    return ", ".join(moving) or "no motor"


def standing(names: Sequence[str], counts: Iterable[int]) -> str:
    """Return absolute counts by motor, all of them: `base 37, shoulder 0`."""
    return ", ".join(f"{name} {count}" for name, count in zip(names, counts, strict=False))


def named(name: str, value: object, message: str = "") -> str:
    """Return a field in words, without its name if the message ends with it; empty if unset."""
    if value is None or (isinstance(value, str | tuple) and not value):
        return ""
    if name == "on":
        return "on" if value else "off"
    stem, _, last = name.rpartition("_")
    unit = f" {UNITS[last]}" if stem and last in UNITS else ""
    label = shown_name(stem if unit else name).lower()
    if message.endswith(f" {label}") and not isinstance(value, bool):
        return f"{valued(value)}{unit}"
    return f"{label} {valued(value)}{unit}"


def valued(value: object) -> str:
    """Return a value in words: what it contains one after the other, numbers without zeros."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Enum):
        return in_words(value)
    if isinstance(value, bytes):
        return value.hex(" ")
    if is_dataclass(value) or isinstance(value, Frame):
        return plain(value)
    if isinstance(value, Mapping):
        return ", ".join(named(str(name), each) for name, each in value.items())
    if isinstance(value, list | tuple):
        return " ".join(map(valued, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


# One message of a device in a recording, and its comparison with that of the simulated device.


class Weight(Enum):
    """How a message is compared."""

    ANSWER = "to the byte"
    MOMENT = "by its kind alone while motors turn, since it depends on the moment; else to the byte"
    PASSING = "not at all: their number and times vary"
    SELF = "not at all: the device describes itself"
    BANNER = "that it comes, once the position is known: the board has restarted"


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a device; only `kind` is compared if its numbers depend on the moment."""

    data: bytes
    weight: Weight
    kind: bytes = b""


class Splitter(Protocol):
    """Splits bytes into messages."""

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the complete messages."""


# Splitting a dialect's bytes into messages and describing them.

LONGEST_LINE = 4096


class AnswerLines:
    """Messages that are lines."""

    def __init__(self, ends: bytes, weigh: Callable[[bytes], Message]) -> None:
        self._lines = LineSplitter(ends, max_length=LONGEST_LINE)
        self._weigh = weigh

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the complete lines."""
        self._lines.feed(data)
        found = []
        while (line := self._lines.next_line()) is not None:
            data = line if isinstance(line, bytes) else line.data
            if data.strip():
                found.append(self._weigh(data.strip()))
        return found


def answer(line: bytes) -> Message:
    """Return a line as a message that is compared to the byte."""
    return Message(line, Weight.ANSWER)


def escaped(data: bytes) -> str:
    """Return bytes as text, with every control character escaped."""
    return data.decode("latin-1").encode("unicode_escape").decode("ascii")


@dataclass(frozen=True, slots=True, eq=False)
class Describer:
    """How a dialect's bytes are split into messages and described.

    `sent` decodes what a host writes at once, `received` one message of the device; both return a
    message or words, and are None if nothing is known of the dialect. `shown` returns bytes as
    text. `sentences` describe messages whose plain words would not explain them.
    """

    splitter: Callable[[], Splitter]
    received: Callable[[bytes], object] | None
    sent: Callable[[bytes], object] | None = None
    shown: Callable[[bytes], str] = escaped
    sentences: Sentences = field(default_factory=lambda: MappingProxyType({}))

    def said(self, data: bytes) -> str:
        """Return one message as text, with its meaning if the bytes do not show it."""
        words = "" if self.shown is escaped else self.words(data, self.received)
        return f"{self.shown(data)} ({words})" if words else self.shown(data)

    def words(self, data: bytes, read: Callable[[bytes], object] | None) -> str:
        """Return what bytes mean; empty if that is unknown."""
        try:
            return "" if read is None else self.wording(read(data))
        except ProtocolError:
            return "unreadable"

    def wording(self, message: object) -> str:
        """Describe one message of this dialect; text is returned unchanged."""
        return wording(message, self.sentences)
