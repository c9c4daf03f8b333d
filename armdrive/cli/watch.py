"""Watch an arm that another program of yours drives: a line of JSON whenever something changes.

Ends when that program gives the arm back, or with Ctrl-C. Watching changes nothing. With --screen
it is drawn instead, with keys for a stop, a pause and a slower tempo; leaving stops nothing.
"""

from __future__ import annotations

import argparse
import contextlib

from armdrive.cli.choosing import add_arm_options
from armdrive.cli.holders import one_holder
from armdrive.cli.numbers import number
from armdrive.cli.output import emit
from armdrive.cli.screens import require_screen
from armdrive.connect.control_socket import WATCH_EVERY_S
from armdrive.errors import ArmError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--every",
        type=number,
        default=WATCH_EVERY_S,
        metavar="SECONDS",
        help=f"look so often (default {WATCH_EVERY_S:g})",
    )
    parser.add_argument("--screen", action="store_true", help="draw it, with keys to stop it")
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Print one status after the other."""
    from armdrive.storage.lock_client import watch_holder

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
    from armdrive.connect.target import find
    from tui import run_watch

    require_screen("watching on a screen", "without --screen it is JSON")
    return run_watch(name, find(name).config.model, ascii_only=ascii_only)
