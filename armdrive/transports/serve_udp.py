"""The device's end of a network wire for other programs: a UDP port.

Every datagram is handed on by itself, and what the device says goes to whoever spoke last.
"""

from __future__ import annotations

import contextlib
import socket
from typing import Any

from armdrive.errors import PortUnavailable
from armdrive.transports.serve import LOOPBACK, split_address

MOST = 65535


class UdpServer:
    """A UDP port; 0 lets one be found. Offered to this computer alone unless a host is named."""

    paced = False

    def __init__(self, host: str = LOOPBACK, port: int = 0) -> None:
        self._host = host
        self._port = port
        self._socket: socket.socket | None = None
        self._peer: tuple[Any, ...] | None = None
        self.open()

    @property
    def address(self) -> str:
        """Host and port."""
        return f"{self._host}:{self._port}"

    @property
    def port(self) -> int:
        """The port number, found by the system where 0 was asked for."""
        return self._port

    @property
    def is_open(self) -> bool:
        """Whether datagrams are heard."""
        return self._socket is not None

    def open(self, address: str | None = None) -> None:
        """Listen, at another address if one is given. Raises `PortUnavailable`."""
        if self._socket is not None:
            return
        if address is not None:
            self._host, self._port = split_address(address)
        ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            ear.bind((self._host, self._port))
        except (OSError, OverflowError) as error:
            ear.close()
            raise PortUnavailable(
                f"cannot listen on {self.address} ({error}): choose another port"
            ) from None
        ear.setblocking(False)
        self._socket, self._port = ear, ear.getsockname()[1]

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""
        return () if self._socket is None else (self._socket.fileno(),)

    def read(self) -> bytes:
        """Return one datagram, or nothing; there may be more."""
        if self._socket is not None:
            with contextlib.suppress(OSError):  # nothing there, or an earlier answer was unwanted
                data, self._peer = self._socket.recvfrom(MOST)
                return data
        return b""

    def write(self, data: bytes) -> None:
        """Send a datagram to whoever spoke last."""
        if self._socket is not None and self._peer is not None and data:
            with contextlib.suppress(OSError):
                self._socket.sendto(data, self._peer)

    def close(self) -> None:
        """Listen no more, and forget who spoke."""
        if self._socket is not None:
            self._socket.close()
        self._socket, self._peer = None, None
