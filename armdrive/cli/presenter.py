"""Printing for people and for programs: sentences, or one JSON document a line.

Everything that the command line prints goes through this module, and what is not printable is
shown as an escape: text may come from a file or a device, and a terminal acts on what it is sent.

A command returns a `Result`, or several: `present` decides which of its two forms is printed. A
command that takes long says meanwhile what it does by `tell`, and shows results as they come by
`show`; `--json` silences the first.
"""

from __future__ import annotations

import argparse
import json
import queue
import sys
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, TextIO

from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.printable import encodable, printable, printable_lines


@dataclass(frozen=True, slots=True)
class Result:
    """What a command comes to: a document for programs, lines for people, and an exit code.

    Lines that are made while they are printed cost nothing with `--json`. Without a document, the
    lines are for people alone.
    """

    document: Mapping[str, Any] | None
    lines: str | Iterable[str] = ()
    code: int = 0


Outcome = int | Result | Iterable[Result]
"""What a command returns: results to be printed, or the exit code where it has printed them."""


def present(outcome: Outcome, options: argparse.Namespace) -> int:
    """Print what a command returned; return its exit code, the highest of several results."""
    if isinstance(outcome, int):
        return outcome
    code = 0
    for result in (outcome,) if isinstance(outcome, Result) else outcome:
        show(result, options)
        code = max(code, result.code)
    return code


def show(result: Result, options: argparse.Namespace) -> None:
    """Print a result in the form that the options ask for."""
    if as_json(options):
        if result.document is not None:
            emit(result.document)
        return
    for line in (result.lines,) if isinstance(result.lines, str) else result.lines:
        say(line)


def tell(options: argparse.Namespace, text: str) -> None:
    """Print a line for people on the way to the result."""
    if not as_json(options):
        say(text)


def as_json(options: argparse.Namespace) -> bool:
    """Return whether the options ask for JSON: then nothing is asked, and no progress told."""
    return bool(getattr(options, "json", False))


def say(text: str) -> None:
    """Print one line, in the words of the command line."""
    put(f"{printable(presented(text, COMMAND_LINE))}\n")


def say_lines(text: str) -> None:
    """Print a text of several lines, in the words of the command line."""
    put(f"{printable_lines(presented(text, COMMAND_LINE))}\n")


def complain(text: str) -> None:
    """Print on the error output, in the words of the command line. It may be several lines."""
    put_error(f"{printable_lines(presented(text, COMMAND_LINE))}\n")


def emit(document: Mapping[str, Any]) -> None:
    """Print a JSON document on a line of its own."""
    say(json.dumps(dict(document)))


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
