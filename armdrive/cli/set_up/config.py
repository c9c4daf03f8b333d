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
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from armdrive.cli.runner import ActionParser, CliCommand

# Actions that talk to a person or an arm need far more than those that read a file.


def _reading_actions() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import config_check, config_default, config_list, config_show

    return {
        "check": config_check,
        "list": config_list,
        "set-default": config_default,
        "show": config_show,
    }


def _asking_actions() -> Mapping[str, CliCommand]:
    from armdrive.cli.set_up import config_limits, config_new, config_signs

    return {"limits": config_limits, "new": config_new, "signs": config_signs}


ACTIONS: Mapping[str, tuple[Callable[[], Mapping[str, CliCommand]], str]] = MappingProxyType(
    {
        "new": (_asking_actions, "ask questions and write an arm file"),
        "signs": (_asking_actions, "turn each motor a little to find which way it counts"),
        "limits": (_asking_actions, "press each limit switch, and see that it raises an alarm"),
        "list": (_reading_actions, "list the arm files"),
        "show": (_reading_actions, "show an arm as armdrive understands its file"),
        "check": (_reading_actions, "say everything that is wrong with an arm file"),
        "set-default": (_reading_actions, "choose the arm that is used where none is named"),
    }
)
"""Every action: what loads it, and its line of help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the actions; each declares its own options once it is chosen."""
    actions = parser.add_subparsers(
        dest="action", required=True, metavar="ACTION", parser_class=ActionParser
    )
    for name, (_, help_line) in ACTIONS.items():
        sub: ActionParser = actions.add_parser(
            name, help=help_line, description=help_line[0].upper() + help_line[1:] + "."
        )
        sub.load = partial(_action, name)


def run(options: argparse.Namespace) -> int:
    """Do what was asked."""
    return _action(options.action).run(options)


def _action(name: str) -> CliCommand:
    load, _ = ACTIONS[name]
    return load()[name]
