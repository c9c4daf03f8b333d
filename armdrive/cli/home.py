"""Reference an arm: tell it that it stands in its reference posture.

An arm without switches has to be brought there by a person, with `armdrive jog` or the pendant.
Nothing moves while you answer. A simulated arm has a simulated operator, who jogs it there.
"""

from __future__ import annotations

import argparse
import sys

from armdrive.cli.choosing import add_arm_options, connect_chosen
from armdrive.cli.confirming import ask_operator
from armdrive.cli.output import emit, say, say_which
from armdrive.view import status_view


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--yes",
        action="store_true",
        help="the arm stands in its reference posture now: do not ask",
    )
    parser.add_argument(
        "--confirm",
        action="store_true",
        help="instead: the arm stands where an earlier command left it",
    )
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Reference the arm and say where it is."""
    with connect_chosen(options) as arm:
        if not options.json:
            say_which(arm.status)
        if options.confirm:
            arm.confirm_restored()
        elif options.yes:
            arm.confirm_reference()
        elif arm.simulated:
            arm.home()
        else:
            arm.home(operator=ask_operator if sys.stdin.isatty() else None)
        if options.json:
            emit(status_view(arm.status))
        else:
            say(f"referenced: tip {arm.pose}")
    return 0
