"""Drive an arm from the keyboard, joint by joint or in Cartesian space.

Holding a key jogs, releasing it stops; space always stops. The screen shows its keys.
"""

from __future__ import annotations

import argparse
import sys

from armdrive.cli.choosing import add_arm_options, connect_chosen
from armdrive.cli.confirming import confirm_simulated
from armdrive.errors import BadRequest


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("--ascii", action="store_true", help="draw without braille characters")
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Open the desk."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise BadRequest("jogging needs a terminal; scripts use jog_j() and jog_l()")
    from tui import run_desk

    with connect_chosen(options, pace="real") as arm:  # the simulated twin of a port's arm, too
        confirm_simulated(arm)
        return run_desk(arm, ascii_only=options.ascii)
