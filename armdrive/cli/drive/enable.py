"""Switch the motors on, where the controller can do that. Moves nothing."""

from __future__ import annotations

import argparse
import contextlib

from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import emit, say
from armdrive.status import status_view


def run(options: argparse.Namespace) -> int:
    """Switch on, and say how the motors stand."""
    with contextlib.closing(connect_chosen(options)) as arm:
        if not options.json:
            say(arm.status.which)
        arm.enable()
        status = arm.status
        if options.json:
            emit(status_view(status))
        else:
            say(f"state {status.state.value}, motor current {status.current.value}")
    return 0
