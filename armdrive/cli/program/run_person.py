"""The person at a run: Enter while a program waits, and Ctrl-C, which stops the arm.

Program files, scripts and the entries of a prompt share this.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from types import FrameType

from armdrive.arm import Arm
from armdrive.cli.commands import INTERRUPTED
from armdrive.cli.program.run_output import Display

# Answers while a program waits: Enter, or `armdrive resume` from elsewhere.

LOOK_EVERY_S = 0.05  # how long a resume from elsewhere may go unnoticed


class PromptLines:
    """Lines of standard input as they are typed, read by a daemon thread.

    The thread reads the file descriptor. Python's own buffer has a lock, which a blocked thread
    would hold while the program ends.
    """

    def __init__(self, number: int | None) -> None:
        self._number = number
        self._lines: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._reading = False

    def forget(self) -> None:
        """Forget what a person typed before being asked; what a pipe brings is an answer."""
        if self._number is not None and os.isatty(self._number):
            with contextlib.suppress(EOFError):
                while self.take():
                    pass

    def take(self) -> bool:
        """Return whether a line has come, and take it. Raises `EOFError` at the end of the input.

        The next call reads on: Ctrl-D at a terminal ends the input only once.
        """
        if not self._reading:
            self._reading = True
            threading.Thread(target=self._read, name="lines", daemon=True).start()
        with contextlib.suppress(queue.Empty):
            self._reading = self._lines.get_nowait()
            if self._reading:
                return True
            raise EOFError
        return False

    @contextlib.contextmanager
    def keys(self) -> Iterator[Pressed]:
        """Yield a function that returns whether a line has come since now."""
        self.forget()
        yield lambda: self.take() or unpressed()

    def _read(self) -> None:
        with contextlib.suppress(OSError):
            while self._number is not None and (data := os.read(self._number, 4096)):
                for _ in range(data.count(b"\n")):
                    self._lines.put(True)
        self._lines.put(False)


def standard_input() -> PromptLines:
    """Return the lines of standard input; none where there is none."""
    try:
        return PromptLines(sys.stdin.fileno())
    except (OSError, ValueError, AttributeError):
        return PromptLines(None)


# Waits a moment, and returns whether Enter was pressed meanwhile.
#
# Raises `EOFError` where it cannot be pressed any more.
Pressed = Callable[[], bool]


def unpressed() -> bool:
    """Wait a moment, without a keyboard."""
    time.sleep(LOOK_EVERY_S)
    return False


class RunTerminal:
    """Shows what a program says; while it waits for a person the arm is paused, as by `pause`.

    `keys` watches for Enter while the program waits for a person; None without a keyboard.
    """

    def __init__(
        self,
        arm: Arm,
        shown: Display,
        keys: Callable[[], AbstractContextManager[Pressed]] | None,
    ) -> None:
        self.say = shown.say
        self._arm = arm
        self._shown = shown
        self._keys = keys

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Wait for Enter, for `armdrive resume` from elsewhere, or until `over()`."""
        keys = self._keys() if self._keys else contextlib.nullcontext(unpressed)
        with self._shown.paused(self._arm), keys as pressed:
            self._shown.waits(text, enter=self._keys is not None)
            while self._arm.status.paused and not over():
                try:
                    if pressed():
                        self._arm.resume()
                        return
                except EOFError:
                    pressed = unpressed
                    self._shown.waits("the input has ended", enter=False)


# The first Ctrl-C stops the arm; the second one leaves at once.


@contextlib.contextmanager
def stopped_by_interrupt(
    arms: Callable[[], Iterable[Arm]], *, ends: bool = True, as_json: bool = False
) -> Iterator[None]:
    """Make the first Ctrl-C stop every arm and end the program, and the next one leave at once.

    Without `ends` only the arms are interrupted: a call that waits for one raises `Stopped`. With
    `as_json` the first one says nothing, since the error that ends the program follows.

    The second Ctrl-C closes nothing: motions that were sent run to their end, and nothing further
    is sent.
    """
    pressed = False

    def interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        nonlocal pressed
        if pressed:
            _leave(arms(), as_json=as_json)
        pressed = True
        for arm in arms():
            arm.request_stop()
        if not as_json:
            _say("\nstopping the arm; Ctrl-C again leaves at once")
        if ends:
            raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGINT, interrupt)
    except ValueError:  # only the main thread receives signals
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave(arms: Iterable[Arm], *, as_json: bool) -> None:
    goes_on_s = max((arm.parts.core.stop_bound().silent_time_s for arm in arms), default=0.0)
    words = f"left: the arm may move for another {goes_on_s:.1f} s; its position will be unknown"
    _say(json.dumps({"event": "left", "text": words}) if as_json else words)
    os._exit(INTERRUPTED)


def _say(words: str) -> None:
    """Write a line past Python's buffer, which a signal may not enter while it is written out.

    The second of two quick presses comes as a rule while the words of the first are written.
    """
    try:
        os.write(sys.stderr.fileno(), f"{words}\n".encode())
    except (OSError, ValueError):  # closed, or none of the system's
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.write(f"{words}\n")
