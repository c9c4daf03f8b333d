"""Ctrl-C while a program runs: once stops the arm, twice leaves at once."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from types import FrameType

from armdrive.arm import Arm

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
