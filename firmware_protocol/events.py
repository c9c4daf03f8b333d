"""Events that several codecs share: unreadable input, and a bounded queue of events."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from firmware_protocol.fields import message
from firmware_protocol.frames import Frame

_Event = TypeVar("_Event")


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


@message()
class Overrun:
    """Reports that input was not fetched in time and is lost: `count` events, or characters."""

    count: int


class EventQueue(Generic[_Event]):
    """A queue of at most `most` events that reports how many it has dropped.

    It keeps the newest events: they say where the device is now.
    """

    def __init__(self, most: int) -> None:
        self._events: deque[_Event] = deque()
        self._most = most
        self._lost = 0

    def put(self, event: _Event) -> None:
        """Add an event; drop the oldest if the queue is full."""
        if len(self._events) == self._most:
            self._events.popleft()
            self._lost += 1
        self._events.append(event)

    def next(self) -> _Event | Overrun | None:
        """Return the number of lost events if any, else the oldest event, or None."""
        if self._lost:
            lost, self._lost = self._lost, 0
            return Overrun(lost)
        return self._events.popleft() if self._events else None

    def discard(self, unwanted: Callable[[_Event], bool]) -> None:
        """Discard the events that match."""
        self._events = deque(event for event in self._events if not unwanted(event))
