"""The device's end of a network wire for other programs: a UDP port.

Every datagram is handed on by itself, and what the device says goes to whoever spoke last.
"""

from __future__ import annotations

import contextlib
import socket
from typing import Any

from armdrive.transports.serve_network import NetworkServer

MOST = 65535


class UdpServer(NetworkServer):
    """A UDP port: each datagram is heard by itself."""

    paced = False
    _peer: tuple[Any, ...] | None = None

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""
        return () if self._ear is None else (self._ear.fileno(),)

    def read(self) -> bytes:
        """Return one datagram, or nothing; there may be more."""
        if self._ear is not None:
            with contextlib.suppress(OSError):  # nothing there, or an earlier answer was unwanted
                data, self._peer = self._ear.recvfrom(MOST)
                return data
        return b""

    def write(self, data: bytes) -> None:
        """Send a datagram to whoever spoke last."""
        if self._ear is not None and self._peer is not None and data:
            with contextlib.suppress(OSError):
                self._ear.sendto(data, self._peer)

    def close(self) -> None:
        """Listen no more, and forget who spoke."""
        super().close()
        self._peer = None

    def _bound(self, host: str, port: int) -> socket.socket:
        ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            ear.bind((host, port))
        except BaseException:
            ear.close()
            raise
        return ear
