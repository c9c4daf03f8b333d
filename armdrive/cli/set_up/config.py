"""Arm files: write one by an interview, list them, show what one means, check it, choose one.

Examples:
  armdrive config new                                 questions, line by line
  armdrive config new bench --template printed-six --yes
  armdrive config signs bench                         which way the motors turn
  armdrive config limits bench                        do the limit switches stop the arm?
  armdrive config show bench --toml                   every key with its value
  armdrive config check bench
  armdrive config set-default bench

Every action prints JSON with --json.

"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.runner import CliCommand
from armdrive.cli.set_up import (
    config_check,
    config_default,
    config_limits,
    config_list,
    config_new,
    config_show,
    config_signs,
)

ACTIONS: Mapping[str, tuple[CliCommand, str]] = MappingProxyType(
    {
        "new": (config_new, "ask questions and write an arm file"),
        "signs": (config_signs, "turn each motor a little to find which way it counts"),
        "limits": (config_limits, "press each limit switch, and see that it raises an alarm"),
        "list": (config_list, "list the arm files"),
        "show": (config_show, "show an arm as armdrive understands its file"),
        "check": (config_check, "say everything that is wrong with an arm file"),
        "set-default": (config_default, "choose the arm that is used where none is named"),
    }
)
"""Every action: the module that does it, and its line of help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the actions, each with its own options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (command, help_line) in ACTIONS.items():
        sub = actions.add_parser(
            name, help=help_line, description=help_line[0].upper() + help_line[1:] + "."
        )
        command.add_arguments(sub)


def run(options: argparse.Namespace) -> int:
    """Do what was asked."""
    command, _ = ACTIONS[options.action]
    return command.run(options)
