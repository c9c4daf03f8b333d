"""Events that wait to be fetched: only so many, the newest."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Generic, TypeVar

_Event = TypeVar("_Event")


@dataclass(frozen=True, slots=True)
class Overrun:
    """So many events were not fetched in time, the oldest; they are lost."""

    count: int


class Waiting(Generic[_Event]):
    """A queue that does not grow beyond `most`, and says how many it has dropped."""

    def __init__(self, most: int) -> None:
        self._events: deque[_Event] = deque()
        self._most = most
        self._lost = 0

    def __len__(self) -> int:
        return len(self._events)

    def put(self, event: _Event) -> None:
        """Add an event; the oldest gives way to it where there is no room."""
        if len(self._events) == self._most:
            self._events.popleft()
            self._lost += 1
        self._events.append(event)

    def next(self) -> _Event | Overrun | None:
        """Return the oldest; before it how many were lost, and None where there is none."""
        if self._lost:
            lost, self._lost = self._lost, 0
            return Overrun(lost)
        return self._events.popleft() if self._events else None

    def clear(self) -> None:
        """Forget them all."""
        self._events.clear()
        self._lost = 0
