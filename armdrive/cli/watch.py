"""Watch an arm that another program of yours drives: a line of JSON whenever something changes.

Ends when that program gives the arm back, or with Ctrl-C. Watching changes nothing.
"""

from __future__ import annotations

import argparse
import contextlib

from armdrive.cli.choosing import add_arm_options
from armdrive.cli.holders import one_holder
from armdrive.cli.numbers import number
from armdrive.cli.output import emit
from armdrive.errors import ArmError
from armdrive.neighbours import WATCH_EVERY_S


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--every",
        type=number,
        default=WATCH_EVERY_S,
        metavar="SECONDS",
        help=f"look so often (default {WATCH_EVERY_S:g})",
    )
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Print one status after the other."""
    from armdrive.holder import watch_holder

    name = one_holder(options)
    with contextlib.suppress(KeyboardInterrupt):  # nothing is stopped by that, but the watching
        for view in watch_holder(name, options.every):
            if "state" not in view:
                raise ArmError(str(view.get("error", "the holder does not let itself be watched")))
            emit(view)
    return 0
