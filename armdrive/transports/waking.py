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
        if ends is None:
            self._event.wait(min(timeout_s, POLL_S))
            self._event.clear()
            return
        ears = [ends[0]] if fileno is None else [fileno, ends[0]]
        longest_s = POLL_S if fileno is None else timeout_s
        readable, _, _ = select.select(ears, [], [], min(timeout_s, longest_s))
        if ends[0] in readable:
            with contextlib.suppress(BlockingIOError):
                os.read(ends[0], 4096)

    def wake(self) -> None:
        """End a `wait`; one that has not begun yet ends at once.

        A signal handler may call it: where there is a pipe, no lock is taken.
        """
        ends = self._ends
        if ends is None:
            self._event.set()
        else:
            with contextlib.suppress(OSError):  # full: it wakes already; closed: nobody sleeps
                os.write(ends[1], b"!")

    def close(self) -> None:
        """Give the pipe back."""
        ends, self._ends = self._ends, None
        for end in ends or ():
            os.close(end)
