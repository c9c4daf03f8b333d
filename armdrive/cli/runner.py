"""Runs one command: parses its options, and turns every error into one line and an exit code."""

from __future__ import annotations

import argparse
import contextlib
import functools
import json
import os
import pkgutil
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from armdrive.cli.commands import COMMANDS, FAULT, INTERRUPTED, REFUSED, USAGE
from armdrive.cli.options import JSON_OPTION, CommandParser, Declare, help_of
from armdrive.cli.presenter import (
    ERROR_LABEL,
    Outcome,
    as_json,
    complain,
    of_output,
    present,
    put_error,
    with_arm,
)
from armdrive.errors import ArmError, BadRequest
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.printable import as_message, in_words
from armdrive.errors.table import error_view, tagged
from kinematics.errors import BadNumber, KinematicsError, UnknownPreset, UnknownSystem, nearest_word


class CommandEnded(BaseException):
    """A signal asked this program to end; no `except Exception` on the way catches it."""

    def __init__(self, number: int) -> None:
        self.number = number
        name = signal.Signals(number).name
        super().__init__(f"ended by {name}; an arm that this command moved was stopped")


def run_command(name: str, function: str, words: list[str]) -> int:
    """Parse the words of a command, load and run it, and return its exit code.

    The command's own modules are loaded after its words are understood, so that help and a wrong
    option do not wait for them. Each action of a command has its own function.
    """
    _fill_closed_streams()
    options = argparse.Namespace(function=function, json=JSON_OPTION in words)
    try:
        command_parser(name, function).parse_args(words, options)
        command: Callable[[argparse.Namespace], Outcome] = command_at(options.function)
        with _signals(), _threads_reported():
            return present(command(options), options)
    except KeyboardInterrupt:
        pressed = KeyboardInterrupt("interrupted; an arm that this command moved was stopped")
        return _say(options, pressed, INTERRUPTED)
    except CommandEnded as ended:
        return _say(options, ended, 128 + ended.number)
    except ArmError as error:
        return _say(options, error, error.exit_code)
    except (BadNumber, UnknownPreset, UnknownSystem) as error:
        return _say(options, error, USAGE)
    except KinematicsError as error:
        return _say(options, error, REFUSED)
    except OSError as error:  # a state folder that cannot be written, a disk that is full
        return _report_system(error, options)
    except Exception as error:
        if _raises_unexpected():
            raise
        return _say(options, _unexpected(error), FAULT)


def command_at(place: str) -> Any:
    """Return what stands at a place such as `drive.move:move`, and import its module if need be."""
    return pkgutil.resolve_name(f"armdrive.cli.{place}")


def report_output(error: OSError) -> int:
    """Report that standard output could not be written; return the exit code."""
    return _report_system(of_output(error), argparse.Namespace())


def _report_system(error: OSError, options: argparse.Namespace) -> int:
    if isinstance(error, BrokenPipeError):
        # the reader of our output has gone (armdrive ... | head): end quietly
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return _say(options, in_words(error), ArmError.exit_code)


@functools.cache  # the shell runs many commands in one process
def command_parser(name: str, function: str) -> CommandParser:
    """Return the parser of a command."""
    group = function.partition(".")[0]
    declare: Declare = command_at(f"{group}.arguments:ARGUMENTS")[name]
    parser = CommandParser(prog=f"armdrive {name}", **help_of(declare))
    declare(parser)
    return parser


def refuse(words: list[str]) -> int:
    """Say that there is no such command, and what to type instead; return the exit code."""
    _fill_closed_streams()
    word = words[0]
    near = nearest_word(word, COMMANDS)
    hint = f"did you mean `armdrive {near}`?" if near else "`armdrive --help` lists all commands"
    options = argparse.Namespace(json=JSON_OPTION in words)
    return _say(options, BadRequest(f"there is no command {word!r}: {hint}"), USAGE)


def _fill_closed_streams() -> None:
    """Point standard streams that were closed at the start to the null device (`armdrive ... <&-`).

    Python sets such a stream to None, and the next port to be opened would get its file number.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115


def _say(options: argparse.Namespace, error: BaseException, code: int) -> int:
    """Print an error on a line of its own, with `--json` as JSON; return the exit code.

    It is in the words of the command line, unless the command has set `options.interface`.
    """
    words = getattr(options, "interface", COMMAND_LINE)
    if as_json(options):
        put_error(f"{presented(json.dumps(error_view(error)), words)}\n")
    else:
        sentence = as_message(with_arm(presented(tagged(error), words), options))
        complain(f"{ERROR_LABEL} {sentence}")
    return code


@contextlib.contextmanager
def _signals() -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into an exception, so that every `with` on the way stops its arm.

    Only the first signal raises: a closed terminal sends several, and another exception would cut
    short what stops the arm and closes its port.
    """
    ended: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        ended.append(number)
        if len(ended) == 1:
            raise CommandEnded(number)

    before = {}
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None:
            before[number] = signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


# Unexpected errors: faults of armdrive itself.


def _raises_unexpected() -> bool:
    """Return whether the environment asks for the traceback."""
    return os.environ.get("ARMDRIVE_TRACEBACK", "") not in ("", "0")


@contextlib.contextmanager
def _threads_reported() -> Iterator[None]:
    """Report unexpected errors in threads in the same way while a command runs."""
    if _raises_unexpected():
        yield
        return
    before = threading.excepthook
    threading.excepthook = _report_thread
    try:
        yield
    finally:
        threading.excepthook = before


def _report_thread(found: threading.ExceptHookArgs) -> None:
    if found.exc_value is not None and not isinstance(found.exc_value, SystemExit):
        with contextlib.suppress(OSError, ValueError):  # the error output is closed
            complain(f"{ERROR_LABEL} {tagged(_unexpected(found.exc_value))}")


def _unexpected(error: BaseException) -> Exception:
    """Save the details of an error; return an error whose message says where."""
    from armdrive.cli.unexpected import Unexpected  # slow to import, and rarely needed

    return Unexpected(error)
