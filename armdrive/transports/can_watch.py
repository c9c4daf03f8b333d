"""What reader and writer of a CAN bus share: counters, the state of the bus, and its loss.

The policy, one place for it: bus-off is a loss at once; error-passive, refused frames and a reader
that only gets errors are one when they last. A frame that is heard clears them all.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol, runtime_checkable

from armdrive.transports.can_health import BusHealth, BusState, left_bus, not_heard

PATIENCE_S = 0.85
"""What lasts this long without a frame being heard is a loss; a standing arm answers oftener."""


@runtime_checkable
class Tells(Protocol):
    """A bus whose adapter says of itself what python-can does not ask it (slcan)."""

    refused: int
    """How many frames the adapter has said it did not send."""
    refusing: bool
    """Whether that is what it said of the last one."""

    def ask(self) -> None:
        """Ask for its status. Called by the writer."""

    def take_status(self) -> int | None:
        """Take the answer, once there is one. Called by the reader."""


class Watch:
    """The one judge of a bus. Called from the reader, the writer and the engine's thread."""

    def __init__(self, clock: Callable[[], float], ring: Callable[[], None]) -> None:
        """`ring` wakes whoever sleeps on the link."""
        self.ended = threading.Event()
        self._clock = clock
        self._ring = ring
        self._lock = threading.Lock()
        self._health = BusHealth()
        self._lost = ""
        self._since: dict[str, tuple[float, str]] = {}

    @property
    def health(self) -> BusHealth:
        """What is known of the bus."""
        return self._health

    @property
    def lost(self) -> str:
        """Why the bus is lost; empty while it is not."""
        return self._lost

    def count(self, **more: int) -> None:
        """Add to counters."""
        with self._lock:
            sums = {name: getattr(self._health, name) + each for name, each in more.items()}
            self._health = replace(self._health, **sums)

    def heard(self, frames: int) -> None:
        """Hear that frames came: somebody else is on the bus, and understood."""
        self.count(heard=frames)
        self._since.clear()

    def state(self, state: BusState, why: str) -> None:
        """Hear what state the adapter's controller is in."""
        with self._lock:
            trouble = why or self._health.last_trouble
            self._health = replace(self._health, state=state, last_trouble=trouble)
        if state is BusState.OFF:
            self.lose(left_bus(why))
        elif state is BusState.PASSIVE:
            self.lasting("passive", not_heard(why))
        else:
            self.settled("passive")

    def lasting(self, kind: str, why: str) -> None:
        """Hear of something that is a loss when it lasts."""
        since_s, _ = self._since.get(kind, (self._clock(), ""))
        self._since[kind] = since_s, why
        with self._lock:
            self._health = replace(self._health, last_trouble=why)

    def settled(self, kind: str) -> None:
        """Hear that it is over."""
        self._since.pop(kind, None)

    def look(self) -> None:
        """Judge what was heard of and is not over yet."""
        for since_s, why in list(self._since.values()):
            if self._clock() - since_s >= PATIENCE_S:
                self.lose(why)

    def lose(self, why: str) -> None:
        """End the link; the first reason is the one that is told."""
        with self._lock:
            self._lost = self._lost or why
        self.ended.set()
        self._ring()
