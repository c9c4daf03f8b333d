"""Printing for people and for programs: sentences, or one JSON document a line.

Everything that the command line prints goes through this module, and what is not printable is
shown as an escape: text may come from a file or a device, and a terminal acts on what it is sent.
"""

from __future__ import annotations

import json
import queue
import sys
import threading
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self, TextIO

from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.printable import encodable, printable, printable_lines


def say(text: str) -> None:
    """Print one line, in the words of the command line."""
    put(f"{printable(presented(text, COMMAND_LINE))}\n")


def say_lines(text: str) -> None:
    """Print a text of several lines, in the words of the command line."""
    put(f"{printable_lines(presented(text, COMMAND_LINE))}\n")


def complain(text: str) -> None:
    """Print on the error output, in the words of the command line. It may be several lines."""
    put_error(f"{printable_lines(presented(text, COMMAND_LINE))}\n")


def emit(document: dict[str, Any]) -> None:
    """Print a JSON document on a line of its own."""
    say(json.dumps(document))


def put(text: str, *, control: str = "", output: TextIO | None = None) -> None:
    """Write text as it is, at once: a prompt, or lines that have their line breaks.

    `control` is written before it and is not escaped: sequences of our own that move the cursor.
    """
    _write(sys.stdout if output is None else output, text, control)


def draw_over(lines: Sequence[str], *, control: str, line_end: str) -> None:
    """Write lines over those that were drawn before, in one piece, so that nothing flickers.

    `control` and `line_end` are sequences of our own, and are written as they are.
    """
    shown = [encodable(printable(line), sys.stdout.encoding) for line in lines]
    sys.stdout.write(control + "".join(f"{line}{line_end}" for line in shown))
    sys.stdout.flush()


def put_error(text: str) -> None:
    """Write text to the error output as `put` does."""
    _write(sys.stderr, text, "")


def _write(output: TextIO, text: str, control: str) -> None:
    shown = encodable(printable_lines(text), getattr(output, "encoding", None))
    output.write(f"{control}{shown}")
    output.flush()


# Progress of a running call, printed by a thread of its own: a blocked terminal must not block
# the engine.


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
