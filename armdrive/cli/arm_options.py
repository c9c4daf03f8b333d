"""The options that say which arm a command is about, and how far its position is trusted."""

from __future__ import annotations

import argparse

from armdrive.cli.options import add_json_option, count, positive
from armdrive.registry import DIALECTS


def add_arm_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose an arm."""
    group = parser.add_argument_group("which arm (none: the simulated TeachMover)")
    group.add_argument("--arm", metavar="NAME", help="an arm file, by name or path")
    group.add_argument("--sim", metavar="DIALECT", choices=list(DIALECTS), help="a simulated arm")
    group.add_argument("--port", metavar="PORT", help="a serial port or a pyserial URL")
    group.add_argument("--dialect", choices=list(DIALECTS), help="what the arm on --port speaks")
    group.add_argument("--baud", type=count, help="baud rate of --port")
    group.add_argument("--fresh", action="store_true", help="a simulated arm: forget its world")
    add_json_option(parser)


def add_allow_restored(parser: argparse.ArgumentParser) -> None:
    """Add `--allow-restored`, for a command that plans motion."""
    parser.add_argument(
        "--allow-restored",
        action="store_true",
        help="trust the position that an earlier command remembered, without asking",
    )


def add_pace_option(parser: argparse._ActionsContainer) -> None:
    """Add `--pace`, for a command that lets a simulated arm go as fast as the computer can."""
    parser.add_argument(
        "--pace",
        type=positive,
        metavar="FACTOR",
        help="a simulated arm: so many times as fast as real time (else as fast as can be)",
    )
