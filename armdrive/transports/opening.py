"""Open the link for a port's name or URL.

/dev/ttyUSB0, COM3            a serial port
spy://PORT?file=NAME          a serial port with its traffic logged to a file
socket://HOST:PORT            raw bytes over TCP
rfc2217://HOST:PORT           a serial port on another computer, including its baud rate
udp://HOST:PORT               one datagram per write
can:INTERFACE:CHANNEL?...     a CAN bus through python-can, as packed frames
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
    """Open the link for a port's name or URL; raises `PortUnavailable` or `BadRequest`.

    The options for DTR apply to serial ports, and are ignored otherwise. Sends nothing.
    """
    if is_can(port):
        return open_can_link(port)
    if scheme(port) == "udp":
        return UdpLink(*host_and_port(port))
    return SerialLink(port, baud, raise_dtr=raise_dtr, keep_dtr_on_close=keep_dtr_on_close)
