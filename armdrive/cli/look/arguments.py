"""What may be typed after the commands that look at an arm and at recordings, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.options import Arguments, add_json_option, number, positive
from armdrive.storage.lock_client import WATCH_EVERY_S
from armdrive.trace.entries import Topic

# --- log


def _log(parser: argparse.ArgumentParser) -> None:
    """Declare what `log` takes.

    Examples:
      armdrive log                              the newest recording
      armdrive log FILE --only errors,intents   two topics of it
      armdrive log FILE --find elbow,speed      the lines that have both words

    Topics: bytes, requests, intents, states, errors. `armdrive record` writes a recording.

    """
    parser.add_argument(
        "file", metavar="FILE", type=Path, nargs="?", help="a recording (.jsonl); else the newest"
    )
    parser.add_argument(
        "--only", metavar="TOPICS", help=f"one or several of {', '.join(Topic)}, with commas"
    )
    parser.add_argument(
        "--find", metavar="WORDS", default="", help="lines with all these words, with commas"
    )
    add_json_option(parser)


# --- replay


def _replay(parser: argparse.ArgumentParser) -> None:
    """Declare what `replay` takes.

    Examples:
      armdrive replay FILE                         the timeline, and the first difference if any
      armdrive replay FILE --show                  the timeline alone
      armdrive replay FILE --set speed_error=0.2   is it so because the motors are slower?

    Ends with 0 if the twin answered as the arm did, with 1 if they part, with 2 if FILE is broken.

    """
    parser.add_argument("file", metavar="FILE", type=Path, help="a recording (.jsonl)")
    parser.add_argument("--show", action="store_true", help="print it, and compare nothing")
    parser.add_argument("--quiet", action="store_true", help="print what was found alone")
    parser.add_argument(
        "--speed", type=positive, metavar="N", help="print at N times the speed of the arm"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting of the twin, as of `armdrive sim`; may be repeated",
    )
    add_json_option(parser)


# --- watch


def _watch(parser: argparse.ArgumentParser) -> None:
    """Declare what `watch` takes.

    Ends when that program gives the arm back, or with Ctrl-C. Watching changes nothing. With
    --screen it is drawn instead, with keys for a stop, a pause and a slower tempo; leaving stops
    nothing.
    """
    parser.add_argument(
        "--every",
        type=number,
        default=WATCH_EVERY_S,
        metavar="SECONDS",
        help=f"look so often (default {WATCH_EVERY_S:g})",
    )
    parser.add_argument("--screen", action="store_true", help="draw it, with keys to stop it")
    add_arm_options(parser)


ARGUMENTS: Mapping[str, Arguments] = MappingProxyType(
    {
        "log": Arguments(_log),
        "replay": Arguments(_replay),
        "status": Arguments(add_arm_options),
        "watch": Arguments(_watch),
    }
)
