"""Drivers of the framework's that outlive the terminal that they paint on."""

from __future__ import annotations

import contextlib
from typing import IO, Any

from textual.driver import Driver


class LastingFile:
    """A terminal to write to, that takes whatever it is given once it is gone.

    The framework writes in a thread, which ends with the first error; who writes then waits for it
    for ever as soon as its queue is full: a desk whose terminal was closed did not always end.
    """

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def write(self, text: str) -> int:
        """Write, if there is still somebody to read it."""
        with contextlib.suppress(OSError, ValueError):
            return self._file.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, if there is still somebody to read it."""
        with contextlib.suppress(OSError, ValueError):
            self._file.flush()

    def __getattr__(self, name: str) -> Any:
        """Leave everything else to the file itself."""
        return getattr(self._file, name)


def lasting(driver: type[Driver]) -> type[Driver]:
    """Return such a driver that outlives its terminal."""

    class Lasting(driver):  # type: ignore[misc, valid-type]
        def __init__(self, *words: Any, **more: Any) -> None:
            super().__init__(*words, **more)
            file: Any = getattr(self, "_file", None)  # a headless one has none
            if file is not None:
                self._file: Any = LastingFile(file)

    return Lasting
