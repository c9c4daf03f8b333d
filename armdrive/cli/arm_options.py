"""The options that choose an arm, and whether to trust its position."""

from __future__ import annotations

import argparse

from armdrive.cli.options import add_json_option, count, name, positive
from armdrive.registry import DIALECTS


def add_arm_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose an arm."""
    group = _add_choice(parser, "the default arm or the simulated TeachMover")
    group.add_argument("--fresh", action="store_true", help="start the simulated arm over")
    add_json_option(parser)


def add_driven_arm_options(parser: argparse.ArgumentParser, otherwise: str) -> None:
    """Add the options that choose an arm that a program is driving; `otherwise` is without one."""
    _add_choice(parser, otherwise)
    add_json_option(parser)


def _add_choice(parser: argparse.ArgumentParser, otherwise: str) -> argparse._ArgumentGroup:
    group = parser.add_argument_group("which arm", f"Without one of these options, {otherwise}.")
    dialects = ", ".join(DIALECTS)
    group.add_argument("--arm", metavar="NAME", type=name, help="an arm file, by name or path")
    group.add_argument(
        "--sim", metavar="DIALECT", choices=list(DIALECTS), help=f"a simulated arm: {dialects}"
    )
    group.add_argument("--port", metavar="PORT", type=name, help="a serial port or a pyserial URL")
    group.add_argument(
        "--dialect",
        metavar="DIALECT",
        choices=list(DIALECTS),
        help="the language of the arm on --port, one of the same",
    )
    group.add_argument("--baud", type=count, metavar="RATE", help="the baud rate of --port")
    return group


EVERY_DRIVEN = "every arm that your programs are driving"
ONLY_DRIVEN = "the only arm that your programs are driving"


def names_arm(options: argparse.Namespace) -> bool:
    """Return whether the options name an arm; otherwise the default one is meant."""
    return bool(options.arm or options.sim or options.port)


def add_allow_restored(parser: argparse.ArgumentParser) -> None:
    """Add `--allow-restored`, for a command that plans motion."""
    parser.add_argument(
        "--allow-restored",
        action="store_true",
        help="trust the position that an earlier command saved, without asking",
    )


def add_pace_option(parser: argparse._ActionsContainer) -> None:
    """Add `--pace`, for a command that runs a simulated arm as fast as the computer can."""
    parser.add_argument(
        "--pace",
        type=positive,
        metavar="FACTOR",
        help="run a simulated arm this many times as fast as real time (default: no waiting)",
    )
