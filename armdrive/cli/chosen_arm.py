"""From the options of a command to the arm that they name, and a connection to it."""

from __future__ import annotations

import argparse

from armdrive.arm import Arm
from armdrive.cli.arm_files import default_arm
from armdrive.cli.sim_state import connect_remembered
from armdrive.connect import target as targets
from armdrive.connect.target import Target
from armdrive.errors import BadRequest
from armdrive.runtime.drive import PaceChoice


def chosen_target(options: argparse.Namespace) -> Target:
    """Return the arm that the options name."""
    named = [word for word in (options.arm, options.sim, options.port) if word]
    if len(named) > 1:
        raise BadRequest("name one arm: --arm, --sim or --port")
    if options.port:
        return targets.find(options.port, dialect_name=options.dialect, baud=options.baud)
    if options.sim:
        return targets.find(f"sim:{options.sim}")
    return targets.find(options.arm or default_arm())


def connect_chosen(
    options: argparse.Namespace,
    *,
    pace: PaceChoice = None,
    allow_restored: bool = False,
    reconnect: bool | None = None,
) -> Arm:
    """Connect to the arm that the options name. A simulated one takes up its remembered world.

    With `reconnect` a real one's lost wire is looked for; None leaves that to its arm file.
    """
    target = chosen_target(options)
    if target.simulated:
        return connect_remembered(
            target.config, fresh=options.fresh, pace=pace, allow_restored=allow_restored
        )
    parts = targets.connect_real(target.config, allow_restored=allow_restored, reconnect=reconnect)
    return Arm(parts)
