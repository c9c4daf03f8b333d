"""`armdrive points save`, `go` and `run`: the actions that connect to the arm."""

from __future__ import annotations

import argparse

from armdrive.cli.chosen_arm import opened_arm
from armdrive.cli.drive.move import moved
from armdrive.cli.presenter import Result, tell
from armdrive.cli.terminal_person import settle_trust
from armdrive.moves import LineMove, PoseMove
from armdrive.programs.teaching.sequence import Stepper
from armdrive.status import status_view
from armdrive.storage.points import point_view


def save(options: argparse.Namespace) -> Result:
    """Save the place where the arm is."""
    with opened_arm(options, allow_restored=True, enabled=True) as arm:
        point = arm.points.teach(options.name, note=options.note, again=options.again)
    return Result({"name": options.name, **point_view(point)}, f"{options.name}: {point.joints}")


def go(options: argparse.Namespace) -> Result:
    """Move to a point, or preview that."""
    kind = LineMove if options.line else PoseMove
    with opened_arm(options, allow_restored=options.allow_restored, enabled=True) as arm:
        settle_trust(arm)
        return moved(arm, kind(options.name, options.speed), options)


def run(options: argparse.Namespace) -> Result:
    """Run a sequence, step by step."""
    with opened_arm(options, allow_restored=options.allow_restored, enabled=True) as arm:
        settle_trust(arm)
        taught = arm.points.read()
        stepper = Stepper(arm, arm.points.sequence(options.name), taught.points)
        stops = arm.stops
        for _ in range(options.times):
            stepper.rewind()
            # a stop between two rounds ends it as well
            stepper.run(lambda step: tell(options, f"{stepper.at + 1:>3}  {step}"), since=stops)
        return Result(status_view(arm.status))
