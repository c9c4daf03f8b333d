"""Where an arm is and whether that can be trusted; asks the program that holds it, if one does."""

from __future__ import annotations

import argparse
import contextlib

from armdrive.cli.choosing import add_arm_options, chosen_target, connect_chosen
from armdrive.cli.output import emit, say
from armdrive.errors import ArmInUse
from armdrive.view import status_view


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Print the status."""
    try:
        with contextlib.closing(connect_chosen(options)) as arm:  # nothing is switched on
            status = arm.status
    except ArmInUse:
        return _of_holder(options)
    if options.json:
        emit(status_view(status))
    else:
        say(str(status))
    return 0


def _of_holder(options: argparse.Namespace) -> int:
    from armdrive.holder import ask_holder

    view = ask_holder(chosen_target(options).config.name, "status")
    if options.json:
        emit(view)
        return 0
    say(f"{view.get('arm')} is held by another program; it says:")
    for key, value in view.items():
        if value not in (None, ""):
            say(f"  {key}: {value}")
    return 0
