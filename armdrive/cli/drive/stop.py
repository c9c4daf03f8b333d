"""Stop an arm that another program of yours drives; without a name, every one of them."""

from __future__ import annotations

import argparse

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.control_requests import ask_all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Ask the holders to stop."""
    return ask_all(options, "stop", "stop", "stopped")
