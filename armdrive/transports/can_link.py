"""A CAN bus as a `Link`: what the engine writes and reads are packed frames, python-can's go out.

Nothing here is ever sent periodically by a driver or a kernel: what keeps an arm moving comes from
the engine alone, and ends with it.
"""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING

from armdrive.errors import LinkLost
from armdrive.transports.bell import Bell
from armdrive.transports.can_address import CanAddress
from armdrive.transports.can_health import BusHealth
from armdrive.transports.can_reader import Reader
from armdrive.transports.can_watch import Watch
from armdrive.transports.can_writer import Writer
from firmware_protocol.frames import Unpacker, pack

if TYPE_CHECKING:
    from collections.abc import Iterable

    import can

LAST_WORDS_S = 0.3
"""So long a link that is closed waits for frames that were written before: a stop, perhaps."""
CLOSING_S = 0.5
"""A driver that does not let go by then is left to itself."""


class CanLink:
    """A `Link` over a python-can bus, with one thread that hears and one that speaks.

    The bus is its own from then on: nobody else may send, receive or shut it down.
    """

    def __init__(self, bus: can.BusABC, name: str, ids: Iterable[int] = ()) -> None:
        """Take a bus. Frames of other `ids` are not heard; without any, all are."""
        self._bus = bus
        self._name = name
        self._bell = Bell()
        self._watch = Watch(time.monotonic, self._bell.ring)
        self._unpacker = Unpacker()
        self._closed = False
        self._writer = Writer(bus, self._watch, time.monotonic)
        self._reader = Reader(
            bus, frozenset(ids), self._watch, ring=self._bell.ring, also=self._writer.look
        )

    @property
    def description(self) -> str:
        """Name the adapter and the bit rate, where it is known."""
        return self._name

    @property
    def health(self) -> BusHealth:
        """Return what was seen of the bus so far."""
        return self._watch.health

    @property
    def waiting(self) -> int:
        """How many frames were written and have not left for the adapter yet."""
        return self._writer.waiting

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - real time is the bus's own
        """Have packed frames sent. Never waits for the bus; raises `LinkLost` once it is lost."""
        self._check()
        self._writer.put(self._unpacker.feed(data))

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Return the frames that have come, packed. Raises `LinkLost` after the last of them."""
        frames = self._reader.take()
        if not frames:
            self._check()
        return b"".join(map(pack, frames))

    def next_s(self) -> float:
        """Return infinity: nobody knows when a real arm answers."""
        return float("inf")

    def wait(self, timeout_s: float) -> None:
        """Sleep until a frame comes, the bus is lost, `wake` is called, or the time is over."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Take the adapter off the bus, once what was written has left or had its time to."""
        if self._closed:
            return
        self._closed = True
        self._writer.drain(LAST_WORDS_S)
        self._watch.ended.set()
        self._writer.join(CLOSING_S)
        self._reader.join(CLOSING_S)
        closing = threading.Thread(target=self._shut_down, name="armdrive-can-end", daemon=True)
        closing.start()
        closing.join(CLOSING_S)
        self._bell.close()

    def _shut_down(self) -> None:
        with contextlib.suppress(Exception):  # it may be gone, in every way that drivers have
            self._bus.shutdown()

    def _check(self) -> None:
        if self._closed:
            raise LinkLost(f"the wire {self._name} is closed: connect again")
        if self._watch.lost:
            raise LinkLost(
                f"the CAN bus on {self._name} was lost: {self._watch.lost}. The arm stands once "
                "its last motion has ended; then connect again"
            )


def open_can_link(port: str) -> CanLink:
    """Open `can:INTERFACE:CHANNEL?...`, or raise `PortUnavailable` or `BadRequest`."""
    address = CanAddress.parse(port)
    from armdrive.transports.can_bus import open_bus

    bus, name = open_bus(address)
    return CanLink(bus, name, address.ids)
