"""Keys that act in the thread that reads them, however busy the app is: what stops the arm.

The app takes such a key afterwards as any other, and does the rest of what it means. What was typed
before it and is still on its way then would begin anew what has just been stopped: it is dropped.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping

from textual import events
from textual.message import Message


class Urgent:
    """The keys that have acted and that the app has not taken yet. Shared by two threads."""

    def __init__(self) -> None:
        self._acted: deque[events.Key] = deque()

    def read(self, message: Message, deeds: Mapping[str, Callable[[], object]]) -> None:
        """Have a key act that was just read, if it has a deed here."""
        if isinstance(message, events.Key) and (deed := deeds.get(message.key)) is not None:
            self._acted.append(message)
            deed()

    def overtook(self, key: events.Key) -> bool:
        """Tell whether a key that the app takes now was typed before one that has acted."""
        if key not in self._acted:
            return bool(self._acted)
        while self._acted.popleft() is not key:
            pass
        return False
