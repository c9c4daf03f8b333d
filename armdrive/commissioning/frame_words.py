"""One frame of a CAN bus in words, whatever its drives speak: for whoever listens."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from firmware_protocol.frames import Frame


class Kind(Enum):
    """What a frame is taken for."""

    REQUEST = "request"
    ANSWER = "answer"
    """Of CANopen also what a node says unasked."""
    UNKNOWN = "unknown"


class Check(Enum):
    """How its last byte is."""

    RIGHT = "right"
    WRONG = "wrong"
    NONE = "none"
    """The frame is no drive's, too short for one, or of a protocol that has none."""


@dataclass(frozen=True, slots=True)
class Said:
    """One frame in words.

    `command` is the name of the code or of the service, empty where none has the number. `node` is
    the drive that it is about, 0 where that is all of them or none.
    """

    frame: Frame
    kind: Kind
    command: str
    words: str
    check: Check
    node: int

    @property
    def foreign(self) -> bool:
        """Whether it is not a readable frame of this protocol."""
        return self.kind is Kind.UNKNOWN

    def view(self, time_s: float) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "time_s": round(time_s, 6),
            "id": self.frame.can_id,
            "node": self.node,
            "frame": str(self.frame),
            "kind": self.kind.value,
            "command": self.command,
            "words": self.words,
            "check": self.check.value,
        }

    def line(self, time_s: float) -> str:
        """Return it as a line for people."""
        arrow = {Kind.REQUEST: ">", Kind.ANSWER: "<", Kind.UNKNOWN: "?"}[self.kind]
        check = "  CHECK BYTE WRONG" if self.check is Check.WRONG and self.command else ""
        return f"{time_s:9.3f}  {self.frame!s:<21} {arrow} {self.words}{check}"


class Ear(Protocol):
    """Hears frames in their order, and knows what was asked."""

    def hear(self, frame: Frame) -> Said:
        """Put a frame into words. Never raises."""
