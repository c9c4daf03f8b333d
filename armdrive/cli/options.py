"""Options and numbers that any command may have. A wrong number is named, never a traceback."""

from __future__ import annotations

import argparse
import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from armdrive.errors import BadRequest
from armdrive.text.speed import parse_speed

Command = Callable[[argparse.Namespace], int]
"""Carries a command out, and returns the exit code."""
Declare = Callable[[argparse.ArgumentParser], None]
"""Declares the options of a command."""


@dataclass(frozen=True, slots=True, eq=False)
class Arguments:
    """What may be typed after a command, and the text that ends its help.

    Where none is given, that is what the declaring function's docstring says after its first line.
    """

    declare: Declare
    epilog: str = ""

    @property
    def help_end(self) -> str:
        """The text that ends the help of the command: notes and examples."""
        return self.epilog or inspect.cleandoc(self.declare.__doc__ or "").partition("\n\n")[2]


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """An action of a command, as `list` of `points`: its line of help, its function, its options.

    The function is written `drive.points:show`: loading.py loads its module to carry the action
    out.
    """

    summary: str
    function: str
    declare: Declare
    epilog: str = ""


def add_actions(parser: argparse.ArgumentParser, actions: Mapping[str, Action]) -> None:
    """Add the actions of a command, one of which has to be named."""
    listed = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, row in actions.items():
        words = help_of(row.summary, Arguments(row.declare, row.epilog))
        action = listed.add_parser(name, help=row.summary, **words)
        row.declare(action)
        action.set_defaults(function=row.function)


def help_of(summary: str, arguments: Arguments) -> Any:
    """Return what an argument parser has to know to print the help of a command or an action."""
    return {
        "description": summary[0].upper() + summary[1:] + ".",
        "formatter_class": argparse.RawDescriptionHelpFormatter,
        "epilog": arguments.help_end,
    }


def add_switches(parser: argparse._ActionsContainer, switches: Mapping[str, str]) -> None:
    """Add options without a value, each with its help."""
    for name, meaning in switches.items():
        parser.add_argument(name, action="store_true", help=meaning)


_MOST_DIGITS = 18
"""Whole numbers have 64 bits wherever they go: into a file, a socket or a system call."""


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def typed_number(text: str) -> float:
    """Return a finite number; digits are 0 to 9, with nothing between. Raises `BadRequest`."""
    try:
        value = float(text)
    except ValueError:
        raise BadRequest(f"{text!r} is not a number") from None
    if not text.isascii() or "_" in text:  # Python would take both: `1_5` for 15
        raise BadRequest(f"{text!r} is not a number")
    if not math.isfinite(value):
        raise BadRequest(f"{text!r} is not a finite number")
    return value


def number(text: str) -> float:
    """Return a finite number, for argparse's `type=`."""
    try:
        return typed_number(text)
    except BadRequest as error:  # argparse shows the words of its own kind of error alone
        raise argparse.ArgumentTypeError(str(error)) from None


def positive(text: str) -> float:
    """Return a number above 0."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not above 0")
    return value


def count(text: str) -> int:
    """Return a whole number above 0."""
    plain = text.isascii() and text.isdecimal() and len(text) <= _MOST_DIGITS
    if not plain or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return int(text)


def fraction(text: str) -> float:
    """Return a speed as a fraction of the limits, for argparse's `type=`."""
    try:
        return parse_speed(text)
    except BadRequest as error:
        raise argparse.ArgumentTypeError(str(error)) from None
