"""Arm files: write one by an interview, list them, show what one means, check it, choose one."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.cli.options import Command

# Actions that talk to a person or an arm need far more than those that read a file.


def _reading_actions() -> Mapping[str, Command]:
    from armdrive.cli.set_up import config_check, config_default, config_list, config_show

    return {
        "check": config_check.run,
        "list": config_list.run,
        "set-default": config_default.run,
        "show": config_show.run,
    }


def _asking_actions() -> Mapping[str, Command]:
    from armdrive.cli.set_up import config_limits, config_new, config_signs

    return {"limits": config_limits.run, "new": config_new.run, "signs": config_signs.run}


ACTIONS: Mapping[str, Callable[[], Mapping[str, Command]]] = MappingProxyType(
    {
        "new": _asking_actions,
        "signs": _asking_actions,
        "limits": _asking_actions,
        "list": _reading_actions,
        "show": _reading_actions,
        "check": _reading_actions,
        "set-default": _reading_actions,
    }
)
"""What loads each action."""


def run(options: argparse.Namespace) -> int:
    """Do what was asked."""
    return ACTIONS[options.action]()[options.action](options)
