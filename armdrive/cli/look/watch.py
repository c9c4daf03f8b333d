"""Watch an arm that another program of yours drives: a line of JSON whenever something changes."""

from __future__ import annotations

import argparse
import contextlib

import tui
from armdrive.cli.control_requests import one_holder
from armdrive.cli.presenter import emit
from armdrive.cli.screens import require_screen
from armdrive.connect.target import find
from armdrive.errors import ArmError
from armdrive.storage.lock_client import watch_holder


def run(options: argparse.Namespace) -> int:
    """Print one status after the other."""
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
