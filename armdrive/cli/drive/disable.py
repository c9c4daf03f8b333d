"""Switch the motors off: the arm can sag, so it is offered to park it first."""

from __future__ import annotations

import argparse
import contextlib
import sys

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import emit, say
from armdrive.cli.screens import agreed
from armdrive.cli.terminal_person import settle_trust
from armdrive.errors import NotReferenced, OperatorNeeded
from armdrive.registry import dialect
from armdrive.status import State, status_view


def run(options: argparse.Namespace) -> int:
    """Park if that is wanted, switch the motors off, and say what that does to the arm."""
    connected = connect_chosen(options, allow_restored=options.allow_restored)
    with contextlib.closing(connected) as arm:  # nothing is switched on by itself
        if not options.json:
            say(arm.status.which)
            say(f"after disable the arm {dialect(arm.status.dialect).torque.disable}")
        if not options.no_park and _wants_to_park(arm, options):
            _park(arm, options)
        arm.disable()
        if options.json:
            emit(status_view(arm.status))
        else:
            say(f"the motors are off: motor current {arm.status.current.value}")
    return 0


def _wants_to_park(arm: Arm, options: argparse.Namespace) -> bool:
    """Ask whether to park; where that is not wanted, whether to switch off all the same."""
    if options.yes or (arm.simulated and not sys.stdin.isatty()):
        return True
    if not sys.stdin.isatty():
        raise OperatorNeeded(
            "the arm can sag when its motors are switched off: say --yes to park it first, or "
            "--no-park to switch off where it stands"
        )
    if agreed("Park the arm first? Type yes: "):
        return True
    if not agreed("Then support the arm. Switch the motors off where it stands? Type yes: "):
        raise OperatorNeeded("not confirmed: the motors were left as they are")
    return False


def _park(arm: Arm, options: argparse.Namespace) -> None:
    settle_trust(arm)
    try:
        arm.core.require_reference()
    except NotReferenced as refusal:
        raise NotReferenced(f"{refusal}; or support the arm and say --no-park") from None
    if arm.core.state is State.DISABLED:
        arm.enable()
    moved = arm.park()
    if not options.json:
        say(f"parked: {moved}")
