"""Options and numbers that any command may have. A wrong number is named, never a traceback."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass

Command = Callable[[argparse.Namespace], int]
"""Carries a command out, and returns the exit code."""
Declare = Callable[[argparse.ArgumentParser], None]
"""Declares the options of a command."""


@dataclass(frozen=True, slots=True, eq=False)
class Arguments:
    """What may be typed after a command, and the text that ends its help."""

    declare: Declare
    epilog: str = ""


_MOST_DIGITS = 18
"""Whole numbers have 64 bits wherever they go: into a file, a socket or a system call."""


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def number(text: str) -> float:
    """Return a finite number, for argparse's `type=`; digits are 0 to 9, with nothing between."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not text.isascii() or "_" in text:  # Python would take both: `1_5` for 15
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


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
    """Return a number above 0 and up to 1."""
    value = number(text)
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not above 0 and up to 1")
    return value
