"""The framework's way to be shown in a browser, made to end when nobody is at its other end.

Its driver reads and writes two pipes to the program that serves the page. When that has died, the
driver stops reading and leaves the app running, which would hold its arm for ever.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from textual import messages
from textual.driver import Driver


def is_served(driver: type[Driver]) -> bool:
    """Tell whether a driver is the one for browsers."""
    return hasattr(driver, "write_meta")


def ending(driver: type[Driver]) -> type[Driver]:
    """Return such a driver that ends its app with its reader."""

    class Ending(driver):  # type: ignore[misc, valid-type]
        def __init__(self, *words: Any, **more: Any) -> None:
            super().__init__(*words, **more)
            self._write: Any = lasting_write(self._write)

        def run_input_thread(self) -> None:
            super().run_input_thread()
            if not self.exit_event.is_set():
                self._app.post_message(messages.ExitApp())

        def process_message(self, message: Any) -> None:
            if not self.exit_event.is_set():  # whoever it was for has gone
                super().process_message(message)

    return Ending


def lasting_write(write: Callable[[bytes], int]) -> Callable[[bytes], int]:
    """Return what writes as long as somebody reads, and raises nothing when nobody does."""

    def written(data: bytes) -> int:
        try:
            return write(data)
        except OSError:
            return len(data)

    return written
