"""Runs one command: parses its options, turns every error into one sentence and an exit code."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import NoReturn, Protocol, cast

from armdrive.cli import COMMANDS
from armdrive.cli.naming import with_arm
from armdrive.cli.output import complain
from armdrive.cli.parsing import Parser
from armdrive.cli.unexpected import FAULT, Unexpected, raises_unexpected, threads_told
from armdrive.errors import ArmError
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.table import error_view, tagged
from armdrive.text.printable import as_message
from kinematics.errors import BadNumber, KinematicsError, UnknownPreset, UnknownSystem

REFUSED = 3
USAGE = 2
INTERRUPTED = 130


class Command(Protocol):
    """What the module of a command offers."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare the command's own options."""

    def run(self, options: argparse.Namespace) -> int:
        """Do it, and return the exit code."""


class Ended(BaseException):
    """A signal asked this program to end; it passes everything that catches errors."""

    def __init__(self, number: int) -> None:
        self.number = number
        name = signal.Signals(number).name
        super().__init__(f"ended by {name}; an arm that moved was stopped")


def run_command(name: str, words: list[str]) -> int:
    """Parse and run a command of the table."""
    _fill_closed_streams()
    module = cast(Command, importlib.import_module(f"armdrive.cli.{name}"))
    parser = Parser(
        prog=f"armdrive {name}",
        description=COMMANDS[name][0].upper() + COMMANDS[name][1:] + ".",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=module.__doc__.partition("\n\n")[2] if module.__doc__ else None,
    )
    options = argparse.Namespace()
    try:
        module.add_arguments(parser)
        parser.parse_args(words, options)
        with _signals(), threads_told():
            return module.run(options)
    except KeyboardInterrupt:
        pressed = KeyboardInterrupt("interrupted; an arm that moved was stopped")
        return _say(options, pressed, INTERRUPTED)
    except Ended as ended:
        return _say(options, ended, 128 + ended.number)
    except ArmError as error:
        return _say(options, error, error.exit_code)
    except (BadNumber, UnknownPreset, UnknownSystem, argparse.ArgumentTypeError) as error:
        return _say(options, error, USAGE)
    except KinematicsError as error:
        return _say(options, error, REFUSED)
    except BrokenPipeError:
        # whoever read our output has gone (armdrive ... | head): end quietly
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # a state folder that cannot be written, a disk that is full
        return _say(options, _in_words(error), ArmError.exit_code)
    except Exception as error:
        if raises_unexpected():
            raise
        return _say(options, Unexpected(error), FAULT)


def _fill_closed_streams() -> None:
    """Let a stream that was closed before we began lead nowhere (`armdrive run x.arm <&-`).

    Else Python has none of that name, and the next port that opens gets its number.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115


def _in_words(error: OSError) -> OSError:
    """Return an error of the system that reads as a sentence, with the file that it is about."""
    if error.filename is None or not error.strerror:
        return error
    file = os.fsdecode(error.filename)
    return OSError(
        f"{file} cannot be used ({error.strerror}): make room or its folder writable, or set "
        "ARMDRIVE_HOME to a folder that is"
    )


def _say(options: argparse.Namespace, error: BaseException, code: int) -> int:
    """Put an error on a line of its own, for the person or, with `--json`, for the program."""
    if getattr(options, "json", False):
        complain(json.dumps(error_view(error)))
    else:
        sentence = as_message(with_arm(presented(tagged(error), COMMAND_LINE), options))
        complain(f"armdrive: {sentence}")
    return code


@contextlib.contextmanager
def _signals() -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into an exception, so that every `with` on the way stops its arm."""

    def end(number: int, frame: FrameType | None) -> NoReturn:  # noqa: ARG001
        raise Ended(number)

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
