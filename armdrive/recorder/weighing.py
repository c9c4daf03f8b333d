"""One message of a device in a recording, and how it is compared with its twin's."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol


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
