"""Where an arm is and whether that can be trusted; asks the program that holds it, if one does."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import emit, say
from armdrive.errors import ArmInUse
from armdrive.status import status_view
from armdrive.storage.lock_client import ask_holder


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
    view = ask_holder(chosen_target(options).config.name, "status")
    if options.json:
        emit(view)
        return 0
    say(f"{view.get('arm')} is held by another program; it says:")
    for key, value in view.items():
        if key == "program" and isinstance(value, dict) and value:
            say(f"  program: {_program_words(value)}")
        elif value not in (None, "", {}):
            say(f"  {key}: {value}")
    return 0


def _program_words(program: dict[str, Any]) -> str:
    """Say which program an arm is at work on, and how far it has come."""
    words = f"{program.get('file')}, line {program.get('line')}: {program.get('text')}"
    percent, left_s = program.get("percent"), program.get("left_s")
    if isinstance(percent, int | float) and isinstance(left_s, int | float):
        words += f" ({percent:.0f} %, {left_s:.0f} s left)"
    return words
