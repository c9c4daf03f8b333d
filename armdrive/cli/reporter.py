"""Progress of a running call, printed by a thread of its own.

A blocked terminal must not block the engine, whose thread reports the progress.
"""

from __future__ import annotations

import queue
import threading
from types import TracebackType
from typing import Self

from armdrive.cli.presenter import say


class TerminalReporter:
    """Prints lines that the engine's thread hands over without waiting."""

    def __init__(self, *, silent: bool) -> None:
        self._silent = silent
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._print, name="reporter", daemon=True)

    def tell(self, line: str) -> None:
        """Hand a line over."""
        self._lines.put(line)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._lines.put(None)
        self._thread.join()

    def _print(self) -> None:
        while (line := self._lines.get()) is not None:
            if not self._silent:
                say(line)
