"""Drives on a CAN bus: set them up one after the other, and watch what passes on the bus.

Examples:
  armdrive can setup bench --port 'can:slcan:/dev/ttyACM0?bitrate=500000'
  armdrive can setup bench --sim                      practise on simulated new drives
  armdrive can monitor can:socketcan:can0             what passes, in words; sends nothing
  armdrive can monitor --arm bench --seconds 5 --json

`armdrive doctor --can` asks who is on a bus, and how the bus is. The page docs/can-setup.md goes
from the box to the first motion.

"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.runner import CliCommand
from armdrive.cli.set_up import can_monitor, can_setup

ACTIONS: Mapping[str, tuple[CliCommand, str]] = MappingProxyType(
    {
        "setup": (can_setup, "commission new drives one at a time, and write the arm file"),
        "monitor": (can_monitor, "show what passes on a bus in words; sends nothing"),
    }
)
"""Every action: the module that does it, and its line of help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the actions, each with its own options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (command, help_line) in ACTIONS.items():
        sub = actions.add_parser(
            name,
            help=help_line,
            description=help_line[0].upper() + help_line[1:] + ".",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            epilog=(command.__doc__ or "").partition("\n\n")[2],
        )
        command.add_arguments(sub)


def run(options: argparse.Namespace) -> int:
    """Do what was asked."""
    command, _ = ACTIONS[options.action]
    return command.run(options)
