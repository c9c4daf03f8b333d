"""Input from the operator while a program runs: Enter, `armdrive resume`, and Ctrl-C."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from types import FrameType
from typing import Protocol

from armdrive.arm import Arm

LOOK_EVERY_S = 0.05


class RunShown(Protocol):
    """What shows a program's words."""

    def say(self, text: str) -> None:
        """Show a line of the program's."""

    def waits(self, text: str) -> None:
        """Show what a person is waited for."""


class PromptLines:
    """Lines of standard input as they are typed, read by a thread that nobody waits for.

    Read by its number and not through Python's own buffer, whose lock a blocked thread would keep
    from a program that ends.
    """

    def __init__(self, number: int | None) -> None:
        self._number = number
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._begun = False

    def forget(self) -> None:
        """Forget what a person typed before being asked; what a pipe brings is an answer."""
        if self._number is not None and os.isatty(self._number):
            while self.take():
                pass

    def take(self) -> bool:
        """Tell whether a line has come, and take it."""
        if not self._begun:
            self._begun = True
            threading.Thread(target=self._read, name="lines", daemon=True).start()
        with contextlib.suppress(queue.Empty):
            self._lines.get_nowait()
            return True
        return False

    def _read(self) -> None:
        if self._number is None:
            return
        with contextlib.suppress(OSError):
            while data := os.read(self._number, 4096):
                for _ in range(data.count(b"\n")):
                    self._lines.put("")


def standard_input() -> PromptLines:
    """Return the lines of standard input; none where there is none."""
    try:
        return PromptLines(sys.stdin.fileno())
    except (OSError, ValueError, AttributeError):
        return PromptLines(None)


class RunTerminal:
    """Shows what a program says; while it waits for a person the arm is paused, as by `pause`."""

    def __init__(self, arm: Arm, shown: RunShown, lines: PromptLines) -> None:
        self._arm = arm
        self._shown = shown
        self._lines = lines

    def say(self, text: str) -> None:
        """Show a line of text."""
        self._shown.say(text)

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Wait for Enter, for `armdrive resume` from elsewhere, or until nobody waits any more."""
        self._lines.forget()
        self._arm.pause()
        self._shown.waits(text)
        while self._arm.paused and not over():
            if self._lines.take():
                self._arm.resume()
                return
            time.sleep(LOOK_EVERY_S)


# The first Ctrl-C stops the arm; the second one leaves at once.

INTERRUPTED = 130


@contextlib.contextmanager
def stopped_by_interrupt(arms: Callable[[], Iterable[Arm]], *, ends: bool = True) -> Iterator[None]:
    """Have the first Ctrl-C stop every arm and end the program, and the next one leave at once.

    Without `ends` nothing but the arms is interrupted: who waits for one hears that it stopped.

    Whoever leaves at once closes nothing: what an arm was sent runs to its end, which its status
    announces, and nothing further is sent.
    """
    pressed = False

    def interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        nonlocal pressed
        if pressed:
            _leave(arms())
        pressed = True
        for arm in arms():
            arm.request_stop()
        _say("\nstopping the arm; Ctrl-C again leaves at once\n")
        if ends:
            raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGINT, interrupt)
    except ValueError:  # not the main thread, which alone hears signals
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave(arms: Iterable[Arm]) -> None:
    bound_s = max((arm.core.stop_bound().silent_time_s for arm in arms), default=0.0)
    _say(f"left: the arm may go on for {bound_s:.1f} s, and nobody remembers where\n")
    os._exit(INTERRUPTED)


def _say(words: str) -> None:
    """Write past Python's buffer: a signal that came while that was written out may not enter it.

    The second of two quick presses comes as a rule while the words of the first are written.
    """
    try:
        os.write(sys.stderr.fileno(), words.encode())
    except (OSError, ValueError):  # closed, or none of the system's
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.write(words)
