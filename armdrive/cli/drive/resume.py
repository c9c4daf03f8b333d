"""Let a paused arm go on with the same motion: LOOK AT THE ARM FIRST, IT MOVES.

Nothing goes on that an error, a stop or a lost wire has ended. Without a name, every arm that a
program of yours holds.
"""

from __future__ import annotations

import argparse

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.control_requests import ask_all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Ask the holders to resume."""
    return ask_all(options, "resume", "resume", "resumed")
