"""A bell that ends a sleep on files: for threads and signal handlers that have something to say."""

from __future__ import annotations

import contextlib
import select
import socket

_ENOUGH = 4096


class Bell:
    """Ends a sleep, from any thread or a signal handler: ringing takes no lock.

    Its sockets are made at the first sleep, so that a bell nobody sleeps on costs nothing.
    """

    def __init__(self) -> None:
        self._rung = False
        self._ends: tuple[socket.socket, socket.socket] | None = None
        self._closed = False

    def ring(self) -> None:
        """End the present sleep, or the next one."""
        self._rung = True  # before looking for the sockets: a sleep looks in the other order
        ends = self._ends
        if ends is not None:
            with contextlib.suppress(OSError):  # full: it rings already; closed: nobody sleeps
                ends[1].send(b"!")

    def wait(self, timeout_s: float, *files: int) -> None:
        """Sleep until one of the files is readable, the bell rings, or the time is over."""
        if self._closed:
            return
        ear = self._ear()
        pause_s = 0.0 if self._rung else max(timeout_s, 0.0)
        ready, _, _ = select.select([*files, ear.fileno()], [], [], pause_s)
        self._rung = False
        if ear.fileno() in ready:
            with contextlib.suppress(BlockingIOError):
                ear.recv(_ENOUGH)

    def close(self) -> None:
        """Give the sockets back."""
        self._closed = True
        ends, self._ends = self._ends, None
        for end in ends or ():
            end.close()

    def _ear(self) -> socket.socket:
        if self._ends is None:
            ends = socket.socketpair()
            for end in ends:
                end.setblocking(False)
            self._ends = ends
        return self._ends[0]
