"""Where an arm is and whether that can be trusted: once, or whenever something changes.

If another program drives the arm, that program answers.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
from collections.abc import Mapping
from typing import Any

import tui
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.control_requests import ask, one_holder
from armdrive.cli.look.status_text import Watched, status_lines
from armdrive.cli.presenter import Result, require_screen, show, tell
from armdrive.connect.target import find
from armdrive.errors import ArmError, ArmInUse
from armdrive.status import status_view
from armdrive.storage.lock_client import holder_words, watch_holder


def status(options: argparse.Namespace) -> Result:
    """Return the status; nothing is switched on."""
    try:
        with contextlib.closing(connect_chosen(options)) as arm:
            view: Mapping[str, Any] = status_view(arm.status)
    except ArmInUse:
        name = chosen_target(options).config.name
        view = ask(name, "status")
        held = f"{holder_words(name)} is driving this arm."
        return Result(view, itertools.chain((held, ""), status_lines(view, options)))
    return Result(view, status_lines(view, options))


def watch(options: argparse.Namespace) -> int:
    """Print a line whenever something changes in an arm that another program drives."""
    name = one_holder(options)
    if options.screen:
        return watch_on_screen(name)
    watched = Watched()
    tell(options, f"watching {name}; Ctrl-C ends the watching and stops nothing")
    with contextlib.suppress(KeyboardInterrupt):
        for view in watch_holder(name, options.every):
            if "state" not in view:
                raise ArmError(str(view.get("error", "the program does not let itself be watched")))
            show(Result(view, watched.lines(view)), options)
    return 0


def watch_on_screen(name: str, *, ascii_only: bool = False) -> int:
    """Draw an arm that another program drives until the user leaves; return the exit code."""
    require_screen("watching on a screen", "leave out --screen for lines of text")
    return tui.run_watch(name, find(name).config.model, ascii_only=ascii_only)
