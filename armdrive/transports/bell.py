"""A bell that ends a `select`: for threads and signal handlers that have something to say."""

from __future__ import annotations

import contextlib
import socket

_ENOUGH = 4096


class Bell:
    """Wakes a `select`, from any thread or a signal handler."""

    def __init__(self) -> None:
        self._ear, self._button = socket.socketpair()
        self._ear.setblocking(False)
        self._button.setblocking(False)

    def fileno(self) -> int:
        """What to select on for reading."""
        return self._ear.fileno()

    def ring(self) -> None:
        """End the present or the next `select` on it."""
        with contextlib.suppress(OSError):  # full: it rings already; closed: nobody listens
            self._button.send(b"!")

    def hush(self) -> None:
        """Be ready for the next ring."""
        with contextlib.suppress(BlockingIOError):
            self._ear.recv(_ENOUGH)

    def close(self) -> None:
        """Give both ends back."""
        self._ear.close()
        self._button.close()
