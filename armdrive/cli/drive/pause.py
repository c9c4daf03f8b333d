"""Have an arm that another program of yours drives wait behind its next burst or segment.

The arm stands, held, until `armdrive resume`; `armdrive stop` ends the motion for good. Without a
name, every arm that a program of yours holds. The controller's own homing is not paused.
"""

from __future__ import annotations

import argparse

from armdrive.cli.arm_options import add_arm_options
from armdrive.cli.control_requests import ask_all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Ask the holders to pause."""
    return ask_all(options, "pause", "pause; `armdrive resume` lets them go on", "paused")
