"""What a TCP and a UDP port for other programs have in common: an address, and how it is taken."""

from __future__ import annotations

import socket
from abc import ABC, abstractmethod

from armdrive.errors import PortUnavailable

LOOPBACK = "127.0.0.1"


def split_address(address: str) -> tuple[str, int]:
    """Split `HOST:PORT`, `:PORT` or `PORT`. Raises `PortUnavailable`."""
    host, _, port = address.rpartition(":")
    if not (port.isascii() and port.isdecimal()):
        raise PortUnavailable(f"{address!r} is no address: write HOST:PORT, for example :7410")
    return host or LOOPBACK, int(port)


class NetworkServer(ABC):
    """A port of this computer; 0 lets one be found. Offered to it alone unless a host is named.

    Anybody who reaches the port can move the simulated arm.
    """

    def __init__(self, host: str = LOOPBACK, port: int = 0) -> None:
        self._host = host
        self._port = port
        self._ear: socket.socket | None = None
        self.open()

    @property
    def address(self) -> str:
        """Host and port, as URLs take them."""
        return f"{self._host}:{self._port}"

    @property
    def port(self) -> int:
        """The port number, found by the system where 0 was asked for."""
        return self._port

    @property
    def is_open(self) -> bool:
        """Whether somebody is heard who calls."""
        return self._ear is not None

    def open(self, address: str | None = None) -> None:
        """Listen, at another address if one is given. Raises `PortUnavailable`."""
        if self._ear is not None:
            return
        if address is not None:
            self._host, self._port = split_address(address)
        try:
            ear = self._bound(self._host, self._port)
        except (OSError, OverflowError) as error:
            raise PortUnavailable(
                f"cannot listen on {self.address} ({error}): choose another port"
            ) from None
        ear.setblocking(False)
        self._ear, self._port = ear, ear.getsockname()[1]

    def close(self) -> None:
        """Listen no more."""
        ear, self._ear = self._ear, None
        if ear is not None:
            ear.close()

    @abstractmethod
    def _bound(self, host: str, port: int) -> socket.socket:
        """Return a socket that listens there. Raises `OSError` or `OverflowError`."""
