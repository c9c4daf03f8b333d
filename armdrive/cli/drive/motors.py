"""Switch the motors on and off, and leave an error: nothing here moves the arm unasked.

An arm whose motors are switched off can sag, so `disable` offers to park it first.
"""

from __future__ import annotations

import argparse
import sys

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import opened_arm
from armdrive.cli.presenter import Result, tell
from armdrive.cli.screens import agreed
from armdrive.cli.terminal_person import settle_trust
from armdrive.errors import NotReferenced, OperatorNeeded
from armdrive.registry import dialect
from armdrive.status import State, status_view


def enable(options: argparse.Namespace) -> Result:
    """Switch on, and say how the motors stand."""
    with opened_arm(options) as arm:
        arm.enable()
        status = arm.status
    return Result(
        status_view(status), f"state {status.state.value}, motor current {status.current.value}"
    )


def reset(options: argparse.Namespace) -> Result:
    """Leave error-stop, and say how the arm is then."""
    with opened_arm(options) as arm:
        arm.reset()
        status = arm.status
    return Result(
        status_view(status),
        f"reset: state {status.state.value}, motor current {status.current.value}, "
        f"position {status.trust.value}",
    )


def disable(options: argparse.Namespace) -> Result:
    """Park if that is wanted, switch the motors off, and say what that does to the arm."""
    with opened_arm(options, allow_restored=options.allow_restored) as arm:
        tell(options, f"after disable the arm {dialect(arm.status.dialect).torque.disable}")
        if not options.no_park and _wants_to_park(arm, options):
            _park(arm, options)
        arm.disable()
        status = arm.status
    return Result(status_view(status), f"the motors are off: motor current {status.current.value}")


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
        arm.referencing.require()
    except NotReferenced as refusal:
        raise NotReferenced(f"{refusal}; or support the arm and say --no-park") from None
    if arm.status.state is State.DISABLED:
        arm.enable()
    tell(options, f"parked: {arm.park()}")
