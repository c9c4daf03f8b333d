"""A CAN bus as a `Link`: the engine reads and writes packed frames, which python-can transports.

No driver or kernel ever repeats a frame periodically: the frames that keep an arm moving come from
the engine alone, and end with it.
"""

from __future__ import annotations

import contextlib
import logging
import sys
import threading
import time
from collections.abc import Iterable
from types import ModuleType
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError, LinkLost, PortUnavailable
from armdrive.transports.address import CanAddress
from armdrive.transports.can_health import BusHealth
from armdrive.transports.can_threads import CanReader, CanWriter, Watch
from armdrive.transports.link import Bell, Link
from armdrive.transports.ports import (
    NOT_INSTALLED,
    can_refusal,
    is_down,
    require_no_terminal,
    unknown_interface,
)
from firmware_protocol.frames import Unpacker, pack

if TYPE_CHECKING:
    import can

DRAIN_S = 0.3  # `close` waits this long for written frames to leave; one may be a stop
CLOSING_S = 0.5  # a driver or thread that has not ended by then is abandoned
STANDARD_MASK = 0x7FF
EXTENDED_MASK = 0x1FFF_FFFF
_RATES = frozenset({"bitrate", "btr", "timing"})


class CanLink(Link):
    """A `Link` over a python-can bus, with one thread that receives and one that sends.

    The link owns the bus: no other code may send, receive or shut it down.
    """

    def __init__(self, bus: can.BusABC, name: str, ids: Iterable[int] = ()) -> None:
        """Take over a bus. Receive only frames with these `ids`, or all frames without any."""
        self._bus = bus
        self._name = name
        self._bell = Bell()
        self._watch = Watch(time.monotonic, self._bell.ring)
        self._unpacker = Unpacker()
        self._closed = False
        self._writer = CanWriter(bus, self._watch, time.monotonic)
        self._reader = CanReader(
            bus, frozenset(ids), self._watch, ring=self._bell.ring, also=self._writer.look
        )

    @property
    def description(self) -> str:
        """Name the adapter, and the bit rate if it is known."""
        return self._name

    @property
    def health(self) -> BusHealth:
        """The state of the bus and its counters so far."""
        return self._watch.health

    @property
    def waiting(self) -> int:
        """The number of written frames that the adapter has not accepted yet."""
        return self._writer.waiting

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - real time is the bus's own
        """Queue packed frames for sending, without waiting. Raises `LinkLost` on a lost bus."""
        self._check()
        self._writer.put(self._unpacker.feed(data))

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Return the received frames, packed. Raises `LinkLost` on a lost bus with none left."""
        frames = self._reader.take()
        if not frames:
            self._check()
        return b"".join(map(pack, frames))

    def wait(self, timeout_s: float) -> None:
        """Sleep until a frame arrives, the bus is lost, `wake` is called, or the timeout."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Take the adapter off the bus, after giving written frames `DRAIN_S` to leave."""
        if self._closed:
            return
        self._closed = True
        self._writer.drain(DRAIN_S)
        self._watch.ended.set()
        self._writer.join(CLOSING_S)
        self._reader.join(CLOSING_S)
        if sys.is_finalizing():
            return  # a thread that is started now never runs, and would be waited for without end
        closing = threading.Thread(target=self._shut_down, name="armdrive-can-end", daemon=True)
        closing.start()
        closing.join(CLOSING_S)
        self._bell.close()

    def _shut_down(self) -> None:
        with contextlib.suppress(Exception):  # drivers fail in many ways if the adapter is gone
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
    bus, name = open_bus(address)
    return CanLink(bus, name, address.ids)


def open_bus(address: CanAddress) -> tuple[can.BusABC, str]:
    """Open the bus of an address; return it and a readable name. Raises `PortUnavailable`.

    Anything that the address leaves out comes from python-can's configuration.
    """
    try:
        import can
    except ImportError as error:
        raise PortUnavailable(f"{NOT_INSTALLED} ({error})") from None
    logger = logging.getLogger("can")
    if not logger.handlers:  # keep its warnings off the terminal; armdrive's errors report them
        logger.addHandler(logging.NullHandler())
    settings = _settings(can, address)
    interface = str(settings.pop("interface"))
    channel = settings.pop("channel", None)
    found = CanAddress(interface, "" if channel is None else str(channel), address.options)
    if down := is_down(found):
        raise down
    if found.device:
        require_no_terminal(found.device)
    if interface == "slcan" and found.channel and not _RATES & settings.keys():
        raise PortUnavailable(
            f"{_name(found, {})} names no bit rate, and an slcan adapter has none of its own: "
            f"write {_name(found, {})}?bitrate=500000"
        )
    # other interfaces would also filter out error frames
    if interface == "socketcan" and address.ids:
        settings["can_filters"] = _filters(address.ids)
    try:
        if interface == "slcan":
            from armdrive.transports.can_slcan import Slcan

            bus: can.BusABC = Slcan(str(channel or ""), **settings)
        else:
            bus = can.Bus(channel=channel, interface=interface, ignore_config=True, **settings)
    except ArmError:
        raise
    except Exception as error:  # every backend has its own kinds
        raise can_refusal(found, error) from None
    return bus, _name(found, settings)


def _settings(python_can: ModuleType, address: CanAddress) -> dict[str, Any]:
    """Return python-can's settings for an address, completed from its configuration."""
    given: dict[str, Any] = dict(address.options)
    if address.interface:
        given["interface"] = address.interface
    if address.channel:
        given["channel"] = address.channel
    try:
        return dict(python_can.util.load_config(config=given))
    except NotImplementedError:
        raise unknown_interface(address, python_can.VALID_INTERFACES) from None
    except (ValueError, TypeError) as error:
        raise PortUnavailable(f"{address} cannot be used: {error}") from None


def _filters(ids: frozenset[int]) -> list[dict[str, int | bool]]:
    return [
        {
            "can_id": each,
            "can_mask": STANDARD_MASK if each <= STANDARD_MASK else EXTENDED_MASK,
            "extended": each > STANDARD_MASK,
        }
        for each in sorted(ids)
    ]


def _name(address: CanAddress, settings: dict[str, Any]) -> str:
    where = str(CanAddress(address.interface, address.channel))
    bitrate = settings.get("bitrate")
    return f"{where} at {bitrate / 1000:g} kbit/s" if isinstance(bitrate, int) else where
