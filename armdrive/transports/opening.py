"""From a port's name or URL to its link: one table of what can stand where a port does.

/dev/ttyUSB0, COM3            a serial port
spy://PORT?file=NAME          a serial port, whose traffic is written to a file
socket://HOST:PORT            raw bytes over TCP
rfc2217://HOST:PORT           a serial port at another computer, with its baud rate
udp://HOST:PORT               one datagram a write
can:INTERFACE:CHANNEL?...     a CAN bus by python-can, in packed frames
"""

from __future__ import annotations

from armdrive.transports.address import host_and_port, is_can, scheme
from armdrive.transports.can_link import open_can_link
from armdrive.transports.link import Link
from armdrive.transports.serial_port import SerialLink
from armdrive.transports.udp import UdpLink


def open_link(
    port: str, baud: int, *, raise_dtr: bool = False, keep_dtr_on_close: bool = False
) -> Link:
    """Open whatever stands where a port does; raises `PortUnavailable` or `BadRequest`.

    The handshake lines are for serial ports and ignored elsewhere. Sends nothing.
    """
    if is_can(port):
        return open_can_link(port)
    if scheme(port) == "udp":
        return UdpLink(*host_and_port(port))
    return SerialLink(port, baud, raise_dtr=raise_dtr, keep_dtr_on_close=keep_dtr_on_close)
