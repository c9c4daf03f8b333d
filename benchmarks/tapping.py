"""Notes what a driver says, once it has been handed to its port or to its CAN adapter."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

import can

from armdrive.arm import Arm
from armdrive.transports.can_link import CanLink
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame, pack


def tap(arm: Arm, said: Callable[[bytes], None]) -> Callable[[], None]:
    """Have `said` hear each piece that has been said; return what ends that.

    What goes to a CAN bus is handed over frame by frame, by a thread of its own, and heard packed.
    """
    link = _own(arm.parts.engine.link)
    return _tap_bus(link._bus, said) if isinstance(link, CanLink) else _tap_link(link, said)


@contextlib.contextmanager
def tapped(arm: Arm, said: Callable[[bytes], None]) -> Iterator[None]:
    """Have `said` hear each piece that is said meanwhile."""
    end = tap(arm, said)
    try:
        yield
    finally:
        end()


def _own(link: Link) -> Link:
    """Return the link itself, where another listens on it."""
    while hasattr(link, "link"):
        link = link.link
    return link


def _tap_link(link: Link, said: Callable[[bytes], None]) -> Callable[[], None]:
    write = link.write

    def watched(data: bytes, now_s: float) -> None:
        write(data, now_s)
        said(data)

    link.write = watched  # type: ignore[method-assign]
    return lambda: setattr(link, "write", write)


def _tap_bus(bus: can.BusABC, said: Callable[[bytes], None]) -> Callable[[], None]:
    send = bus.send

    def watched(msg: can.Message, timeout: float | None = None) -> None:
        send(msg, timeout)
        said(pack(Frame(msg.arbitration_id, bytes(msg.data))))

    bus.send = watched  # type: ignore[method-assign]
    return lambda: setattr(bus, "send", send)
