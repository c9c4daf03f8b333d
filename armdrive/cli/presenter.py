"""The terminal: prints for people and for programs, and reads the lines that a person types.

Everything that the command line prints goes through this module. Text may come from a file or a
device, and a terminal acts on control characters, so this module prints those as escapes.

A command returns a `Result`, or several, and `present` prints one of its two forms: sentences, or
one JSON document a line. A command that takes long reports its progress with `tell`, which `--json`
silences, and prints results early with `show`.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, TextIO

from armdrive.cli.options import ARM_OPTIONS, typed_again
from armdrive.errors import BadRequest
from armdrive.errors.actions import COMMAND_LINE, Words, presented
from armdrive.errors.printable import command_line, encodable, printable, printable_lines
from kinematics.text import folded

if sys.platform != "win32":
    import termios


class Ink(Enum):
    """Colours of words on a terminal, as the numbers of ANSI's "select graphic rendition"."""

    GOOD = "32"
    CAUTION = "33"
    BAD = "1;31"
    FAINT = "2"


@dataclass(frozen=True, slots=True)
class Inked:
    """A part of a line that a terminal shows in a colour."""

    text: str
    ink: Ink


# One line for people. Its parts hold no colours of their own: what a device sends stays text.
Line = str | tuple[str | Inked, ...]


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome of a command: a document for programs, lines for people, and an exit code.

    A generator of lines runs only if the lines are printed. Without a document, `--json` prints
    nothing. `verbatim` lines are for another program or a file, and are printed as they are.
    """

    document: Mapping[str, Any] | None
    lines: str | Iterable[Line] = ()
    code: int = 0
    verbatim: bool = False


# What a command returns: results to print, or its exit code if it has printed them itself.
Outcome = int | Result | Iterable[Result]


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
        if result.verbatim and isinstance(line, str):
            put(f"{line}\n")
        else:
            say(line)


def tell(options: argparse.Namespace, text: str) -> None:
    """Print a line about progress, except with `--json`."""
    if not as_json(options):
        say(text)


def as_json(options: argparse.Namespace) -> bool:
    """Return whether the options ask for JSON, so that no questions are asked."""
    return bool(getattr(options, "json", False))


def say(line: Line) -> None:
    """Print one line, in the words of the command line. A terminal gets it folded to its width."""
    parts = [_shown(part) for part in ((line,) if isinstance(line, str) else line)]
    rows = fit("".join(text for text, _ in parts), sys.stdout)
    _send((_in_inks(rows, parts) if has_colour(sys.stdout) else rows) + "\n", sys.stdout)


def say_lines(text: str) -> None:
    """Print a text of several lines as `say` prints one."""
    for line in text.split("\n"):
        say(line)


def complain(text: str, words: Words = COMMAND_LINE) -> None:
    """Print on the error output, in the words of an interface. It may be several lines."""
    put_error(f"{fit(printable_lines(presented(text, words)), sys.stderr)}\n")


def emit(document: Mapping[str, Any]) -> None:
    """Print a JSON document on a line of its own."""
    put(f"{presented(json.dumps(dict(document)), COMMAND_LINE)}\n")


def fit(text: str, output: TextIO) -> str:
    """Return lines folded to the width of a terminal; other outputs get them as they are.

    A terminal itself would break them in the middle of a word.
    """
    if not output.isatty():
        return text
    columns = shutil.get_terminal_size().columns
    return "\n".join(row for line in text.split("\n") for row in folded(line, columns))


def put(text: str, *, control: str = "", output: TextIO | None = None) -> None:
    """Write text as it is, at once: a prompt, or lines that have their line breaks.

    `control` is written before it and is not escaped: sequences of our own that move the cursor.
    """
    stream = sys.stdout if output is None else output
    _send(control + _printable(text, stream), stream)


# Begins every error; a terminal shows it in red.
ERROR_LABEL = "armdrive:"


def put_error(text: str) -> None:
    """Write text to the error output as `put` does."""
    label = ""
    if text.startswith(ERROR_LABEL) and has_colour(sys.stderr):
        label, text = _in_ink(ERROR_LABEL, Ink.BAD), text.removeprefix(ERROR_LABEL)
    put(text, control=label, output=sys.stderr)


def _printable(text: str, output: TextIO) -> str:
    """Return text with escapes for what is not printable, or not in the encoding of a stream."""
    return encodable(printable_lines(text), getattr(output, "encoding", None))


def of_output(error: OSError) -> OSError:
    """Return an error of the output with its name; the system's own error names no file."""
    return OSError(error.errno, error.strerror, "the output")


def _send(text: str, output: TextIO) -> None:
    try:
        output.write(text)
        output.flush()
    except OSError as error:
        raise of_output(error) from None


# Colours.

# Values of `TERM` for terminals that only print line after line: they neither draw nor colour.
WITHOUT_SCREEN = ("dumb", "unknown")


def has_colour(output: TextIO) -> bool:
    """Return whether to write colours: to a terminal that knows them, unless NO_COLOR is set."""
    return (
        output.isatty()
        and not os.environ.get("NO_COLOR")
        and os.environ.get("TERM", "").lower() not in WITHOUT_SCREEN
        and (os.name != "nt" or "WT_SESSION" in os.environ)  # older consoles print the sequences
    )


def _shown(part: str | Inked) -> tuple[str, Ink | None]:
    text, ink = (part, None) if isinstance(part, str) else (part.text, part.ink)
    return _printable(printable(presented(text, COMMAND_LINE)), sys.stdout), ink


def _in_inks(text: str, parts: Iterable[tuple[str, Ink | None]]) -> str:
    """Return a text whose parts have colours; one that was folded stays without."""
    at = 0
    for part, ink in parts:
        found = text.find(part, at)
        if found < 0:
            continue
        shown = part if ink is None else _in_ink(part, ink)
        text = text[:found] + shown + text[found + len(part) :]
        at = found + len(shown)
    return text


def _in_ink(text: str, ink: Ink) -> str:
    return f"\x1b[{ink.value}m{text}\x1b[0m"


# Reading from the terminal.


def at_terminal() -> bool:
    """Return whether a person reads the output and types the input."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def require_screen(what: str, otherwise: str) -> None:
    """Raise `BadRequest` if the terminal cannot draw; `otherwise` names what works without."""
    if not at_terminal():
        raise BadRequest(f"{what} needs a terminal; {otherwise}")
    kind = os.environ.get("TERM", "")
    if kind.lower() in WITHOUT_SCREEN:
        raise BadRequest(
            f"{what} needs a terminal that can draw, and this one has TERM={kind}; {otherwise}. "
            "If it can draw after all, use: TERM=xterm-256color armdrive ..."
        )


def typed(prompt: str) -> str | None:
    """Return the next line of the input, from the terminal or a pipe; None at its end."""
    put(f"{fit(prompt.rstrip(), sys.stdout)} ")
    line = sys.stdin.readline()
    if not line:
        put("\n")  # the next text starts on a new line, not after the prompt
        return None
    return line.strip()


def forget_typed() -> None:
    """Forget the lines that were typed or pasted at the terminal and not read yet."""
    if sys.platform != "win32" and sys.stdin.isatty():
        with contextlib.suppress(termios.error, OSError, ValueError, AttributeError):
            termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)


def confirmation(question: str) -> str | None:
    """Return what is typed once the question is shown: a line from before confirms nothing."""
    forget_typed()
    return typed(question)


def agreed(question: str) -> bool:
    """Ask a question at the terminal; any answer but yes means no."""
    if not sys.stdin.isatty():
        return False
    answer = confirmation(question)
    return answer is not None and answer.lower() in ("yes", "y")


# Remedies name a command. If this command named its arm, the next one has to name it as well.

# The commands in remedies that act on the arm that their options name.
_ARM_COMMANDS = ("disable", "enable", "home", "jog", "move", "reset", "resume", "status", "verify")

# Needs the arm file, which says what is expected.
_FIX = "`armdrive doctor --fix`"

_COMMAND = rf"`armdrive ((?:{'|'.join(_ARM_COMMANDS)})(?: --[a-z-]+)*)`"


def with_arm(sentence: str, options: argparse.Namespace) -> str:
    """Return a sentence whose commands name the arm as the options of this command do."""
    words = typed_again(options, *ARM_OPTIONS)
    if not words:
        return sentence
    if getattr(options, "arm", None):
        fix = command_line("doctor", "--arm", options.arm, "--fix")
        sentence = sentence.replace(_FIX, f"`{fix}`")

    def named(found: re.Match[str]) -> str:
        name, *rest = found[1].split()
        return f"`{command_line(name, *words, *rest)}`"

    return re.sub(_COMMAND, named, sentence)
