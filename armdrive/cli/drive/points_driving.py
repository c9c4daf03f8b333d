"""`armdrive points save`, `go` and `run`: what is done with points where an arm is connected."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.preview_report import run_move
from armdrive.cli.options import Command
from armdrive.cli.presenter import emit, say
from armdrive.cli.terminal_person import settle_trust
from armdrive.moves import LineMove, PoseMove
from armdrive.programs.teaching.sequence import Stepper
from armdrive.status import status_view
from armdrive.storage.points import point_view


def _save(options: argparse.Namespace) -> int:
    with connect_chosen(options, allow_restored=True) as arm:
        if not options.json:
            say(arm.status.which)
        point = arm.points.teach(options.name, note=options.note, again=options.again)
    if options.json:
        emit({"name": options.name, **point_view(point)})
    else:
        say(f"{options.name}: {point.joints}")
    return 0


def _go(options: argparse.Namespace) -> int:
    kind = LineMove if options.line else PoseMove
    move = kind(options.name, options.speed)
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say(arm.status.which)
        settle_trust(arm)
        return run_move(arm, move, options)


def _run(options: argparse.Namespace) -> int:
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say(arm.status.which)
        settle_trust(arm)
        taught = arm.points.read()
        stepper = Stepper(arm, arm.points.sequence(options.name), taught.points)
        shown = None if options.json else lambda step: say(f"{stepper.at + 1:>3}  {step}")
        stops = arm.stops
        for _ in range(options.times):
            stepper.rewind()
            stepper.run(shown, since=stops)  # a stop between two times ends it as well
        if options.json:
            emit(status_view(arm.status))
    return 0


ACTIONS: Mapping[str, Command] = MappingProxyType({"save": _save, "go": _go, "run": _run})
"""What does each action."""
