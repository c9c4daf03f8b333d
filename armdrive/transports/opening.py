"""Open the link for a port's name or URL.

/dev/ttyUSB0, COM3            a serial port
socket://HOST:PORT            raw bytes over TCP
rfc2217://HOST:PORT           a serial port on another computer, including its baud rate
udp://HOST:PORT               one datagram per write
can:INTERFACE:CHANNEL?...     a CAN bus through python-can, as packed frames
"""

from __future__ import annotations

import logging
from types import ModuleType
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError, PortUnavailable
from armdrive.transports.address import CanAddress, host_and_port, is_can, scheme
from armdrive.transports.can_link import CanLink
from armdrive.transports.link import Link
from armdrive.transports.ports import (
    NOT_INSTALLED,
    can_refusal,
    is_down,
    require_no_terminal,
    unknown_interface,
)
from armdrive.transports.serial_port import SerialLink
from armdrive.transports.udp import UdpLink

if TYPE_CHECKING:
    import can

_RATES = frozenset({"bitrate", "btr", "timing"})
# Interfaces that return each frame to its sender as if another node had sent it (python-can 4.6).
# A drive's confirmation may be equal to its order, so an order would confirm itself.
_ECHOES = frozenset({"udp_multicast"})


def open_link(
    port: str, baud: int, *, raise_dtr: bool = False, keep_dtr_on_close: bool = False
) -> Link:
    """Open the link for a port's name or URL; raises `PortUnavailable` or `BadRequest`.

    The options for DTR apply to serial ports, and are ignored otherwise. Sends nothing.
    """
    if is_can(port):
        return open_can_link(port)
    if scheme(port) == "udp":
        return UdpLink(*host_and_port(port))
    return SerialLink(port, baud, raise_dtr=raise_dtr, keep_dtr_on_close=keep_dtr_on_close)


def open_can_link(port: str) -> CanLink:
    """Open `can:INTERFACE:CHANNEL?...`, or raise `PortUnavailable` or `BadRequest`."""
    address = CanAddress.parse(port)
    bus, name = open_bus(address)
    try:
        return CanLink(bus, name, address.ids)
    except BaseException:  # as Ctrl-C: the threads of a driver would outlive this program
        bus.shutdown()
        raise


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
    if interface in _ECHOES:
        raise PortUnavailable(
            f"{_name(found, {})} returns every frame to its sender, so an order would look "
            "confirmed that no drive has received: use another interface"
        )
    if down := is_down(found):
        raise down
    if found.device:
        require_no_terminal(found.device)
    if interface == "slcan" and found.channel and not _RATES & settings.keys():
        raise PortUnavailable(
            f"{_name(found, {})} names no bit rate, and an slcan adapter has none of its own: "
            f"write {_name(found, {})}?bitrate=500000"
        )
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


def _name(address: CanAddress, settings: dict[str, Any]) -> str:
    where = str(CanAddress(address.interface, address.channel))
    bitrate = settings.get("bitrate")
    return f"{where} at {bitrate / 1000:g} kbit/s" if isinstance(bitrate, int) else where
