"""Switch the motors on and off, and clear an error; only `disable` can move the arm, to park it.

Without motor current an arm can sag, so `disable` offers to park it first.
"""

from __future__ import annotations

import argparse
import sys

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import opened_arm
from armdrive.cli.presenter import Result, agreed, tell
from armdrive.cli.terminal_operator import settle_trust
from armdrive.errors import NotReferenced, OperatorNeeded
from armdrive.registry import dialect
from armdrive.status import outcome_words, status_view


def enable(options: argparse.Namespace) -> Result:
    """Switch the motors on, and return the status."""
    with opened_arm(options) as arm:
        arm.enable()
        status = arm.status
    return Result(status_view(status), outcome_words(status))


def reset(options: argparse.Namespace) -> Result:
    """Leave error-stop, and return the status."""
    with opened_arm(options) as arm:
        arm.reset()
        status = arm.status
    return Result(status_view(status), f"reset: {outcome_words(status)}")


def disable(options: argparse.Namespace) -> Result:
    """Park if wanted, switch the motors off, and say what that does to the arm."""
    with opened_arm(options) as arm:
        tell(options, dialect(arm.status.dialect).torque.disable_warning)
        if not options.no_park and _wants_to_park(arm, options):
            _park(arm, options)
        arm.disable()
        status = arm.status
    return Result(status_view(status), outcome_words(status))


def _wants_to_park(arm: Arm, options: argparse.Namespace) -> bool:
    """Return whether to park first. Raises `OperatorNeeded` if the motors are to stay on."""
    if options.yes or (arm.simulated and not sys.stdin.isatty()):
        return True
    if not sys.stdin.isatty():
        raise OperatorNeeded(
            "the arm can sag when its motors are switched off: give --yes to park it first, or "
            "--no-park to switch off where it stands"
        )
    if agreed("Park the arm first? Type yes: "):
        return True
    if not agreed("Then support the arm. Switch the motors off where it stands? Type yes: "):
        raise OperatorNeeded("not confirmed: the motors were not switched off")
    return False


def _park(arm: Arm, options: argparse.Namespace) -> None:
    settle_trust(arm)
    try:
        arm.parts.core.require_reference()
    except NotReferenced as refusal:
        raise NotReferenced(f"{refusal}; or support the arm and give --no-park") from None
    arm.enable()
    tell(options, f"parked: {arm.park()}")
