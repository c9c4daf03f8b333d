"""Runs one command: parses its options, turns every error into one sentence and an exit code."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import shlex
import signal
import sys
import threading
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from types import FrameType
from typing import NoReturn

from armdrive.cli.options import Arguments, help_of, load
from armdrive.cli.presenter import Outcome, as_json, complain, present, put_error
from armdrive.errors import ArmError
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.printable import as_message
from armdrive.errors.table import error_view, named, tagged
from kinematics.errors import BadNumber, KinematicsError, UnknownPreset, UnknownSystem, nearest_word

REFUSED = 3
USAGE = 2
INTERRUPTED = 130
FAULT = 70
"""What sysexits.h calls EX_SOFTWARE: an internal error."""


class CommandEnded(BaseException):
    """A signal asked this program to end; it passes everything that catches errors."""

    def __init__(self, number: int) -> None:
        self.number = number
        name = signal.Signals(number).name
        super().__init__(f"ended by {name}; an arm that moved was stopped")


class CommandParser(argparse.ArgumentParser):
    """An argument parser whose errors print nothing that a terminal would act on.

    They quote what was typed.
    """

    def exit(self, status: int = 0, message: str | None = None) -> NoReturn:
        """End the program as `ArgumentParser` does, with a printable message."""
        super().exit(status, None if message is None else as_message(message))


def run_command(name: str, summary: str, function: str, words: list[str]) -> int:
    """Parse the words of a command, load and run it, and return its exit code.

    What a command needs to run is loaded once its words are understood: help and a wrong option
    do not wait for it. An action of a command has a function of its own.
    """
    _fill_closed_streams()
    group = function.partition(".")[0]
    arguments: Arguments = load(f"{group}.arguments:ARGUMENTS")[name]
    parser = CommandParser(prog=f"armdrive {name}", **help_of(summary, arguments))
    options = argparse.Namespace(function=function)
    try:
        arguments.declare(parser)
        parser.parse_args(words, options)
        command: Callable[[argparse.Namespace], Outcome] = load(options.function)
        with _signals(), _threads_told():
            return present(command(options), options)
    except KeyboardInterrupt:
        pressed = KeyboardInterrupt("interrupted; an arm that moved was stopped")
        return _say(options, pressed, INTERRUPTED)
    except CommandEnded as ended:
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
        if _raises_unexpected():
            raise
        return _say(options, _unexpected(error), FAULT)


def refuse(word: str, known: Collection[str]) -> int:
    """Say that there is no such command, and which one may be meant; return the exit code."""
    code = named("BadRequest").code
    near = nearest_word(word, known)
    hint = f"did you mean `armdrive {near}`?" if near else "`armdrive --help` lists them all"
    put_error(as_message(f"armdrive: [{code}] there is no command {word!r}; {hint}\n"))
    return USAGE


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
    if as_json(options):
        complain(json.dumps(error_view(error)))
    else:
        sentence = as_message(with_arm(presented(tagged(error), COMMAND_LINE), options))
        complain(f"armdrive: {sentence}")
    return code


@contextlib.contextmanager
def _signals() -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into an exception, so that every `with` on the way stops its arm."""

    def end(number: int, frame: FrameType | None) -> NoReturn:  # noqa: ARG001
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


# Errors that nobody foresaw.


def _raises_unexpected() -> bool:
    """Tell whether the environment asks for the exception itself."""
    return os.environ.get("ARMDRIVE_TRACEBACK", "") not in ("", "0")


@contextlib.contextmanager
def _threads_told() -> Iterator[None]:
    """Have an unforeseen error in a thread told in the same way while a command runs."""
    if _raises_unexpected():
        yield
        return
    before = threading.excepthook
    threading.excepthook = _tell_of_thread
    try:
        yield
    finally:
        threading.excepthook = before


def _tell_of_thread(found: threading.ExceptHookArgs) -> None:
    if found.exc_value is not None and not isinstance(found.exc_value, SystemExit):
        with contextlib.suppress(OSError, ValueError):  # the error output is closed
            complain(f"armdrive: {tagged(_unexpected(found.exc_value))}")


def _unexpected(error: BaseException) -> Exception:
    """Write the details of an error down; return the one that says where they are."""
    from armdrive.cli.unexpected import Unexpected  # slow to import, and hardly ever needed

    return Unexpected(error)


# Remedies name a command. Where this command named its arm, the next one has to name it as well.

_OF_AN_ARM = ("disable", "enable", "home", "jog", "move", "reset", "status", "verify")
"""The commands that remedies tell to run, and that act on the arm that their options name."""

_MENDING = "`armdrive doctor --mend`"
"""Needs the arm file: it says what is expected."""

_COMMAND = rf"`armdrive ((?:{'|'.join(_OF_AN_ARM)})(?: --[a-z-]+)*)`"


def with_arm(sentence: str, options: argparse.Namespace) -> str:
    """Return a sentence whose commands name the arm as the options of this one did."""
    words = _named(options)
    if not words:
        return sentence
    if getattr(options, "arm", None):
        mending = f"`armdrive doctor --arm {shlex.quote(str(options.arm))} --mend`"
        sentence = sentence.replace(_MENDING, mending)
    return re.sub(_COMMAND, lambda found: f"`armdrive {_insert(found[1], words)}`", sentence)


def _insert(command: str, words: str) -> str:
    if "--arm" in command:
        return command
    name, _, rest = command.partition(" ")
    return " ".join(filter(None, (name, words, rest)))


def _named(options: argparse.Namespace) -> str:
    given = [
        (f"--{name}", str(value))
        for name in ("arm", "sim", "port", "dialect")
        if (value := getattr(options, name, None))
    ]
    return shlex.join(word for pair in given for word in pair)
