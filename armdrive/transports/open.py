"""From a port's name or URL to its link: one table of what can stand where a port does.

/dev/ttyUSB0, COM3            a serial port
spy://PORT?file=NAME          a serial port, whose traffic is written to a file
socket://HOST:PORT            raw bytes over TCP
rfc2217://HOST:PORT           a serial port at another computer, with its baud rate
udp://HOST:PORT               one datagram a write
can:INTERFACE:CHANNEL?...     a CAN bus by python-can, in packed frames
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from armdrive.errors import BadRequest
from armdrive.transports.address import is_can

if TYPE_CHECKING:
    from armdrive.transports.link import Link

TCP_SCHEMES = frozenset({"socket", "rfc2217"})
NETWORK_SCHEMES = TCP_SCHEMES | {"udp"}


def open_link(
    port: str, baud: int, *, raise_dtr: bool = False, keep_dtr_on_close: bool = False
) -> Link:
    """Open whatever stands where a port does; raises `PortUnavailable` or `BadRequest`.

    The handshake lines are for serial ports and ignored elsewhere. Sends nothing.
    """
    if is_can(port):
        from armdrive.transports.can_link import open_can_link

        return open_can_link(port)
    if scheme(port) == "udp":
        from armdrive.transports.udp import UdpLink

        return UdpLink(*host_and_port(port))
    from armdrive.transports.serial_port import SerialLink

    return SerialLink(port, baud, raise_dtr=raise_dtr, keep_dtr_on_close=keep_dtr_on_close)


def scheme(port: str) -> str:
    """Return what stands before `://`, in small letters; empty for a plain name or a CAN bus."""
    if is_can(port):
        return ""
    before, found, _ = port.partition("://")
    return before.lower() if found else ""


def host_and_port(url: str) -> tuple[str, int]:
    """Read the host and the port number of a network URL. Raises `BadRequest`."""
    parts = urlsplit(url)
    try:
        number = parts.port
    except ValueError:
        number = None
    if not parts.hostname or not number:
        raise BadRequest(
            f"{url} is no address: write host and port number, for example "
            f"{parts.scheme or 'socket'}://192.168.4.1:2217"
        )
    return parts.hostname, number
