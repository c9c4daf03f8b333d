"""Which arm a command is about: the options that all commands share, and connecting to it."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from armdrive.cli.numbers import count, positive
from armdrive.errors import BadRequest
from armdrive.registry import DEFAULT, DIALECTS
from armdrive.storage import files as places

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.connect.target import Target

DEFAULT_SIM = f"sim:{DEFAULT}"
DEFAULT_FILE = "default"


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


def add_json_option(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def chosen_target(options: argparse.Namespace) -> Target:
    """Return the arm that the options name."""
    from armdrive.connect.target import find

    named = [word for word in (options.arm, options.sim, options.port) if word]
    if len(named) > 1:
        raise BadRequest("name one arm: --arm, --sim or --port")
    if options.port:
        return find(options.port, dialect_name=options.dialect, baud=options.baud)
    if options.sim:
        return find(f"sim:{options.sim}")
    return find(options.arm or default_arm())


def default_arm() -> str:
    """Return the arm where none is named: ARMDRIVE_ARM, the chosen one, `default.toml`, or sim."""
    from armdrive.cli.config_files import chosen_default

    named = os.environ.get("ARMDRIVE_ARM") or chosen_default()
    if named:
        return named
    if (places.arm_files() / f"{DEFAULT_FILE}.toml").is_file():
        return DEFAULT_FILE
    return DEFAULT_SIM


def connect_chosen(
    options: argparse.Namespace,
    *,
    pace: str | float | None = None,
    allow_restored: bool = False,
    reconnect: bool | None = None,
) -> Arm:
    """Connect to the arm that the options name. A simulated one takes up its remembered world.

    With `reconnect` a real one's lost wire is looked for; None leaves that to its arm file.
    """
    from armdrive.arm import Arm
    from armdrive.connect.target import connect_real

    target = chosen_target(options)
    if target.simulated:
        from armdrive.cli.worlds import connect_remembered

        return connect_remembered(
            target.config, fresh=options.fresh, pace=pace, allow_restored=allow_restored
        )
    return Arm(connect_real(target.config, allow_restored=allow_restored, reconnect=reconnect))
