"""Slow an arm that another program of yours drives, to so many percent of the speed it asks for.

Holds for what is sent next, bursts, segments and jogs, until it is changed; 100 ends it. Without a
name, every arm that a program of yours holds.

Examples:
  armdrive slow 20
  armdrive slow 100 --arm bench

"""

from __future__ import annotations

import argparse

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.control_requests import ask_all
from armdrive.cli.options import number


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("percent", type=_percent, help="1 to 100")
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Ask the holders to go slower."""
    done = f"go with {options.percent:g} % of the speed"
    return ask_all(options, "slow", done, "slowed", percent=options.percent)


def _percent(word: str) -> float:
    percent = number(word)
    if not 1.0 <= percent <= 100.0:
        raise argparse.ArgumentTypeError(f"give 1 to 100 percent, not {word}")
    return percent
