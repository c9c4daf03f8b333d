"""Sleeping on a file until bytes arrive or somebody calls, by a pipe to oneself."""

from __future__ import annotations

import contextlib
import os
import select
import threading

POLL_S = 0.005
"""Where a file cannot be slept on (Windows, network ports), it is looked at this often."""


class Waker:
    """Waits on one file descriptor, and can be woken from any thread."""

    def __init__(self) -> None:
        self._event = threading.Event()
        self._ends: tuple[int, int] | None = None
        if os.name == "posix":
            self._ends = os.pipe()
            for end in self._ends:
                os.set_blocking(end, False)

    def wait(self, fileno: int | None, timeout_s: float) -> None:
        """Sleep until the file is readable, `wake` is called, or the time is over."""
        ends = self._ends
        if fileno is None or ends is None:
            self._event.wait(min(timeout_s, POLL_S))
            self._event.clear()
            return
        readable, _, _ = select.select([fileno, ends[0]], [], [], timeout_s)
        if ends[0] in readable:
            with contextlib.suppress(BlockingIOError):
                os.read(ends[0], 4096)

    def wake(self) -> None:
        """End a `wait`; one that has not begun yet ends at once."""
        self._event.set()
        if self._ends is not None:
            with contextlib.suppress(OSError):
                os.write(self._ends[1], b"!")

    def close(self) -> None:
        """Give the pipe back."""
        ends, self._ends = self._ends, None
        for end in ends or ():
            os.close(end)
