"""Drives on a CAN bus: set them up one after the other, and watch what passes on the bus."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.options import Command
from armdrive.cli.set_up import can_monitor, can_setup

ACTIONS: Mapping[str, Command] = MappingProxyType(
    {"setup": can_setup.run, "monitor": can_monitor.run}
)
"""What does each action."""


def run(options: argparse.Namespace) -> int:
    """Do what was asked."""
    return ACTIONS[options.action](options)
