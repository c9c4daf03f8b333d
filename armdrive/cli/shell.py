"""Type the words of a program at a prompt: each is carried out at once.

A line is checked and carried out as it is entered; a block (repeat, while, if, define ... end) when
its end is. Names, subprograms and the speed stay. `help` lists the words, `save stack.arm` writes
what was carried out as a program. Ctrl-C stops the arm. docs/shell.md tells more.

Examples:
  armdrive shell
  armdrive shell --arm bench
  armdrive shell --put A,250,0                a block on the simulated arm's table
  armdrive shell < morning.txt                lines of a file; ends at the first error

"""

from __future__ import annotations

import argparse
import contextlib
import sys
from typing import TYPE_CHECKING

from armdrive.cli.choosing import (
    add_allow_restored,
    add_arm_options,
    add_pace_option,
    chosen_target,
    connect_chosen,
)
from armdrive.cli.confirming import settle_trust
from armdrive.cli.numbers import number
from armdrive.cli.output import say_which
from armdrive.cli.putting import add_put_option, put_blocks, require_table
from armdrive.errors import OperatorNeeded

if TYPE_CHECKING:
    from armdrive.arm import Arm


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_put_option(parser)
    parser.add_argument("--speed", type=number, metavar="PERCENT", help="go slower than asked for")
    add_pace_option(parser)
    add_allow_restored(parser)
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Take lines until they end."""
    from armdrive.cli.run_common import make_ready
    from armdrive.cli.shell_loop import from_a_pipe, from_a_terminal

    at_terminal = sys.stdin.isatty() and not options.json
    require_table(chosen_target(options), options.put)
    arm = connect_chosen(options, pace=options.pace, allow_restored=options.allow_restored)
    with contextlib.closing(arm):
        put_blocks(arm, options.put)
        if not options.json:
            say_which(arm.status)
        _settle(arm, at_terminal)
        make_ready(arm, options)
        return (from_a_terminal if at_terminal else from_a_pipe)(arm, options)


def _settle(arm: Arm, at_terminal: bool) -> None:
    """Settle whether the position can be trusted; at a terminal a no leaves the prompt there."""
    try:
        settle_trust(arm)
    except OperatorNeeded:
        if not at_terminal:
            raise
    if at_terminal and not arm.simulated:
        from armdrive.cli.shell_person import ask_at_prompt

        arm.operator = ask_at_prompt
