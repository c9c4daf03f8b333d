"""Any message in words, made of its name and its fields; and how counts of motors are written."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Protocol

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
