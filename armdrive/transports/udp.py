"""A controller on a network over UDP: a write is one datagram, received ones are concatenated."""

from __future__ import annotations

import socket

from armdrive.errors import LinkLost
from armdrive.transports.link import Bell, Link, lost_link
from armdrive.transports.ports import no_connection

LONGEST_BYTES = 65507  # most data in one datagram over IPv4
MOST_DATAGRAMS = 64  # a limit per read, so that a flood cannot block the engine


class UdpLink(Link):
    """A `Link` over UDP to one host and port; datagrams from other senders are ignored.

    UDP does not report lost datagrams: the answer simply does not arrive.
    """

    def __init__(self, host: str, port: int) -> None:
        """Create the socket; raises `NoConnection` if the host is unknown. Sends nothing."""
        shown = f"[{host}]" if ":" in host else host
        self._name = f"udp://{shown}:{port}"
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(
                host, port, type=socket.SOCK_DGRAM
            )[0]
            self._socket = _connected(family, kind, protocol, address)
        except OSError as error:
            raise no_connection(self._name, error) from None
        self._bell = Bell()
        self._closed = False

    @property
    def description(self) -> str:
        """Name the host and the port."""
        return self._name

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - real time is the net's own
        """Send bytes as one datagram."""
        if not data:
            return
        try:
            self._socket.send(data)
        except OSError as error:
            raise self._lost(error) from None

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Return what has arrived."""
        data = bytearray()
        try:
            for _ in range(MOST_DATAGRAMS):
                data += self._socket.recv(LONGEST_BYTES)
        except BlockingIOError:
            pass
        except OSError as error:
            if not data:
                raise self._lost(error) from None
        return bytes(data)

    def tune(self, baud: int) -> None:
        """Do nothing: datagrams have no baud rate."""

    def wait(self, timeout_s: float) -> None:
        """Sleep until a datagram arrives, `wake` is called, or the timeout."""
        if self._closed:
            return
        self._bell.wait(timeout_s, self._socket.fileno())

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Close the socket."""
        self._closed = True
        self._socket.close()
        self._bell.close()

    def _lost(self, error: OSError) -> LinkLost:
        if isinstance(error, ConnectionRefusedError | ConnectionResetError):
            why = "no program listens there"
        else:
            why = str(error)
        return lost_link(f"the connection to {self._name}", why, "check that the controller is on")


def _connected(family: int, kind: int, protocol: int, address: tuple[object, ...]) -> socket.socket:
    made = socket.socket(family, kind, protocol)
    try:
        made.setblocking(False)
        made.connect(address)
    except BaseException:
        made.close()
        raise
    return made
