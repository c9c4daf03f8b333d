"""Where an arm is and whether that can be trusted: once, or whenever something changes.

An arm that another program holds tells it through that program.
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

import tui
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.control_requests import one_holder
from armdrive.cli.presenter import Result, emit
from armdrive.cli.screens import require_screen
from armdrive.connect.target import find
from armdrive.errors import ArmError, ArmInUse
from armdrive.status import status_view
from armdrive.storage.lock_client import ask_holder, watch_holder


def status(options: argparse.Namespace) -> Result:
    """Return the status; nothing is switched on."""
    try:
        with contextlib.closing(connect_chosen(options)) as arm:
            found = arm.status
    except ArmInUse:
        view = ask_holder(chosen_target(options).config.name, "status")
        return Result(view, _of_holder(view))
    return Result(status_view(found), str(found))


def _of_holder(view: Mapping[str, Any]) -> Iterator[str]:
    yield f"{view.get('arm')} is held by another program; it says:"
    for key, value in view.items():
        if key == "program" and isinstance(value, dict) and value:
            yield f"  program: {_program_words(value)}"
        elif value not in (None, "", {}):
            yield f"  {key}: {value}"


def _program_words(program: Mapping[str, Any]) -> str:
    """Say which program an arm is at work on, and how far it has come."""
    words = f"{program.get('file')}, line {program.get('line')}: {program.get('text')}"
    percent, left_s = program.get("percent"), program.get("left_s")
    if isinstance(percent, int | float) and isinstance(left_s, int | float):
        words += f" ({percent:.0f} %, {left_s:.0f} s left)"
    return words


def watch(options: argparse.Namespace) -> int:
    """Print a line of JSON whenever something changes in an arm that another program drives."""
    name = one_holder(options)
    if options.screen:
        return watch_on_screen(name)
    with contextlib.suppress(KeyboardInterrupt):  # nothing is stopped by that, but the watching
        for view in watch_holder(name, options.every):
            if "state" not in view:
                raise ArmError(str(view.get("error", "the holder does not let itself be watched")))
            emit(view)
    return 0


def watch_on_screen(name: str, *, ascii_only: bool = False) -> int:
    """Draw a held arm until somebody leaves; return the exit code."""
    require_screen("watching on a screen", "without --screen it is JSON")
    return tui.run_watch(name, find(name).config.model, ascii_only=ascii_only)
