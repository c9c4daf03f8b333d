"""The options of the commands that look at an arm and at recordings, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.options import (
    ONLY_DRIVEN,
    Declare,
    add_arm_options,
    add_driven_arm_options,
    add_json_option,
    add_options,
)
from armdrive.storage.lock_client import WATCH_EVERY_S
from armdrive.trace.entries import Topic

# --- log


def _log(parser: argparse.ArgumentParser) -> None:
    """Read a recording in words: bytes, requests, calls, states, errors.

    `armdrive record` writes a recording, and so does every fault.

    Operands:
      [FILE]  a recording (.jsonl); without one, the newest

    Options:
      --find WORDS  only lines with all these words, separated by commas

    Examples:
      armdrive log                                  the newest recording
      armdrive log monday.jsonl --only errors,calls
      armdrive log monday.jsonl --find elbow,speed  lines with both words

    """
    topics = f"only these topics, separated by commas: {', '.join(Topic)}"
    parser.add_argument("--only", metavar="TOPICS", help=topics)
    add_options(parser, _log)
    parser.set_defaults(find="")
    add_json_option(parser)


# --- replay


def _replay(parser: argparse.ArgumentParser) -> None:
    """Replay a recording on a simulated arm, and show where the two differ.

    Operands:
      FILE  a recording (.jsonl)

    Options:
      --quiet           print the result only
      --set NAME=VALUE  a setting of the simulated arm, as in `armdrive sim`; may be repeated

    A simulated arm gets the bytes that the recorded arm got. The exit code is 0 if it answers as
    the recorded arm did, 1 if it does not, and 2 if the file cannot be used or holds no answer.
    `armdrive log` prints a recording without comparing anything.

    Examples:
      armdrive replay monday.jsonl                         up to the first difference, if any
      armdrive replay monday.jsonl --set speed_error=0.2   would slower motors explain it?

    """
    add_options(parser, _replay)
    add_json_option(parser)


# --- status


def _status(parser: argparse.ArgumentParser) -> None:
    """Show where an arm is, whether that can be trusted, and what to do next.

    Nothing moves and no motor is switched on. If another program drives the arm, that program
    answers.

    Examples:
      armdrive status
      armdrive status --sim grbl
      armdrive status --json

    """
    add_arm_options(parser)


# --- watch


def _watch(parser: argparse.ArgumentParser) -> None:
    """Follow an arm that another program is driving.

    Options:
      --every SECONDS  time between two looks (default %(default)g)
      --screen         draw the arm, with keys to stop it

    Prints a line for each change, until the program releases the arm or you press Ctrl-C, which
    does not stop the arm. With --screen the arm is drawn, with keys that stop, pause and slow it
    down.

    Examples:
      armdrive watch
      armdrive watch --sim teachmover --every 1
      armdrive watch --json

    """
    add_options(parser, _watch)
    parser.set_defaults(every=WATCH_EVERY_S)
    add_driven_arm_options(parser, ONLY_DRIVEN)


ARGUMENTS: Mapping[str, Declare] = MappingProxyType(
    {
        "log": _log,
        "replay": _replay,
        "status": _status,
        "watch": _watch,
    }
)
