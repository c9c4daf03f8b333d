"""Leave error-stop, after looking at the arm. Moves nothing.

A controller that is locked, or in alarm, stays so from one command to the next: this unlocks it. A
position that is suspect stays suspect, until the arm is homed.
"""

from __future__ import annotations

import argparse
import contextlib

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import emit, say, say_which
from armdrive.status import status_view


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Reset, and say how the arm is then."""
    with contextlib.closing(connect_chosen(options)) as arm:
        if not options.json:
            say_which(arm.status)
        arm.reset()
        status = arm.status
        if options.json:
            emit(status_view(status))
        else:
            say(
                f"reset: state {status.state.value}, motor current {status.current.value}, "
                f"position {status.trust.value}"
            )
    return 0
