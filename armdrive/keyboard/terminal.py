"""A terminal that hands over every byte as it comes, and is left as it was found."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Iterator
from typing import Protocol


class Terminal(Protocol):
    """A terminal whose keys are neither echoed nor gathered into lines."""

    def write(self, data: bytes) -> None:
        """Send bytes to it."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return what has come, after at most so long; b"" where nothing has."""
        ...

    def now_s(self) -> float:
        """Return the time on a clock that never goes back."""
        ...


@contextlib.contextmanager
def raw_terminal() -> Iterator[Terminal]:
    """Take over the terminal of this process, and give it back however this ends."""
    if os.name == "nt":
        yield _Console()
        return
    import termios
    import tty

    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)
    try:
        tty.setcbreak(number)  # Ctrl-C still ends the program
        yield _Tty(number)
    finally:
        termios.tcsetattr(number, termios.TCSAFLUSH, before)


class _Tty:
    def __init__(self, number: int) -> None:
        self._number = number

    def write(self, data: bytes) -> None:
        sys.stdout.flush()
        os.write(sys.stdout.fileno(), data)

    def read(self, timeout_s: float) -> bytes:
        import select

        ready, _, _ = select.select([self._number], [], [], timeout_s)
        return os.read(self._number, 4096) if ready else b""

    def now_s(self) -> float:
        return time.monotonic()


class _Console:
    """Windows: keys come one by one, and a short sleep between looks loses no precision needed."""

    LOOK_S = 0.002

    def write(self, data: bytes) -> None:
        sys.stdout.write(data.decode("ascii"))
        sys.stdout.flush()

    def read(self, timeout_s: float) -> bytes:
        import msvcrt

        until_s = self.now_s() + timeout_s
        while not msvcrt.kbhit():  # type: ignore[attr-defined,unused-ignore]
            if self.now_s() >= until_s:
                return b""
            time.sleep(self.LOOK_S)
        return bytes(msvcrt.getch())  # type: ignore[attr-defined,unused-ignore]

    def now_s(self) -> float:
        return time.perf_counter()
