"""Leave error-stop, after looking at the arm. Moves nothing."""

from __future__ import annotations

import argparse
import contextlib

from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import emit, say
from armdrive.status import status_view


def run(options: argparse.Namespace) -> int:
    """Reset, and say how the arm is then."""
    with contextlib.closing(connect_chosen(options)) as arm:
        if not options.json:
            say(arm.status.which)
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
