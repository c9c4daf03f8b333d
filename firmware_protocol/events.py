"""Events that several codecs share: input that is unreadable or answers nothing.

The owner of a codec fetches what it has found before it feeds more, so no queue of events is
limited.
"""

from __future__ import annotations

from firmware_protocol.fields import message
from firmware_protocol.frames import Frame


@message()
class Unreadable:
    """Bytes that are no message, or not one that belongs here, and the reason."""

    data: bytes
    reason: str


@message()
class Stray:
    """A readable message that answers nothing, for example an answer that comes too late."""

    answer: object


@message()
class UnreadableFrame:
    """A CAN frame that is no message, or not one that belongs here, and the reason."""

    frame: Frame
    reason: str
