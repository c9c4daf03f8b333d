"""Signals that end a program, kept back while a simulated engine takes a step.

On simulated time the engine runs on the thread that waits, and that is where Python calls signal
handlers, which often raise. An engine torn apart in mid-step would send a motion twice or wait
for an answer that it has already heard; a step lasts a fraction of a millisecond.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self

_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")


class SignalsBetweenSteps:
    """While entered, handlers of ending signals run at `deliver` and at the end, nowhere else.

    Only the main thread hears signals: on any other thread this does nothing.
    """

    def __init__(self) -> None:
        self._handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self._heard: list[int] = []

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for name in _ENDING:
                number = getattr(signal, name, None)  # Windows has no SIGHUP
                handler = signal.getsignal(number) if number is not None else None
                if number is not None and callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self.deliver()

    def deliver(self) -> None:
        """Call the handlers of what has been heard; whatever they raise is raised here."""
        while self._heard:
            number = self._heard.pop(0)
            self._handlers[number](number, None)

    def _note(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self._heard.append(number)
