"""The reference of an arm: establish it, and measure how far the arm has drifted."""

from __future__ import annotations

import argparse
import sys

from armdrive.arm import Arm
from armdrive.arm.reference import homes_by_switches
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import opened_arm
from armdrive.cli.options import named_number
from armdrive.cli.presenter import Result, agreed, as_json, say, tell
from armdrive.cli.terminal_operator import TerminalOperator, ready_arm
from armdrive.errors import BadRequest, OperatorNeeded
from armdrive.motion.reference import Verdict, Verified, verified_view
from armdrive.motion.resolve import park_pose
from armdrive.moves import GRIPPER_AXIS
from armdrive.status import State, status_view
from kinematics.spaces import Joints, Pose

PARK = "park"
# Shown for a real arm: the next program cannot know whether the arm was moved by hand.
NEXT = (
    "Each later command first asks whether the arm still stands as it was left; in a script, add "
    "--allow-restored."
)
RESETS = (
    "If the board restarts when its port is opened, the position does not outlast this command: "
    "write raise_dtr = true and keep_dtr_on_close = true under [connection] of the arm file."
)
WAY_CLEAR = "Is its way clear, and your hand at the power switch? Type yes: "


def home(options: argparse.Namespace) -> Result:
    """Reference the arm, and return its status."""
    declared = _declared(options)  # what is wrong is refused before anything is opened
    if options.switches and not homes_by_switches(chosen_target(options).config):
        raise BadRequest("this arm has no switches, or its arm file has no [homing] section")
    with opened_arm(options) as arm:
        _reference(arm, options, declared)
        lines = [f"referenced: tip {arm.pose}"]
        if not arm.simulated:
            lines.append(NEXT)
        if arm.abilities.resets_on_open and not (arm.simulated or arm.config.connection.keeps_dtr):
            lines.append(RESETS)
        return Result(status_view(arm.status), lines)


def _reference(
    arm: Arm, options: argparse.Namespace, declared: tuple[Joints | Pose, float] | None
) -> None:
    if options.yes:
        arm.enable()
        arm.reference.confirm()
    elif declared is not None:
        posture, opening_mm = declared
        arm.enable()
        arm.reference.declare(posture, opening_mm=opening_mm)
    elif arm.reference.homes_by_switches:
        _by_switches(arm, options)
    elif arm.simulated and not options.guide:
        arm.enable()
        arm.home()
    elif as_json(options):
        arm.home()  # refuses: a person has to look
    else:
        _guided(arm)


def _guided(arm: Arm) -> None:
    guide = TerminalOperator()
    if not guide.prepare(arm, off=arm.status.state is State.DISABLED):
        raise OperatorNeeded(
            "not confirmed: nothing was moved or referenced. Answer the questions in a terminal, "
            "or state where the arm is: --yes (its reference posture) or --declare JOINT=DEG ..."
        )
    arm.home(operator=guide)


def _by_switches(arm: Arm, options: argparse.Namespace) -> None:
    tell(options, arm.reference.homing_words)
    sure = options.switches or arm.simulated
    if not sure and (as_json(options) or not agreed(WAY_CLEAR)):
        raise OperatorNeeded("not confirmed, so nothing moved: answer yes, or give --switches")
    arm.enable()
    arm.home()


def _declared(options: argparse.Namespace) -> tuple[Joints | Pose, float] | None:
    """Return the posture that --declare names and the opening of its fingers, if it is given."""
    if not options.declare:
        return None
    config = chosen_target(options).config
    if options.declare == [PARK]:
        if config.park is None and config.model.reference is None:
            raise BadRequest("this arm has no park posture: add [park] to its arm file")
        return park_pose(config), 0.0
    names = config.model.arm.joint_names
    given = dict(map(named_number, options.declare))
    known = (*names, GRIPPER_AXIS)
    if unknown := [name for name in given if name not in known]:
        raise BadRequest(f"write NAME=DEGREES with one of {', '.join(known)}, not {unknown[0]!r}")
    opening_mm = given.pop(GRIPPER_AXIS, 0.0)
    if missing := [name for name in names if name not in given]:
        raise BadRequest(f"every joint needs an angle: {', '.join(missing)} missing")
    return Joints.of(*(given[name] for name in names), names=names), opening_mm


# Measuring the drift: with its finger tips on the mark, the arm shows where it really is.

OFF = 1
FINE = "Use small jogs, such as shoulder 0.1. The smallest jog is one motor step."


def verify(options: argparse.Namespace) -> Result:
    """Measure the drift, and return it."""
    with ready_arm(options) as arm:
        verified = _verified(arm, options)
    right = verified.accepted or verified.verdict is Verdict.ROUNDING
    return Result(verified_view(verified), (str(verified),), 0 if right else OFF)


def _verified(arm: Arm, options: argparse.Namespace) -> Verified:
    if arm.simulated:
        return arm.reference.verify(accept=options.accept, speed=options.speed)
    if as_json(options):
        return arm.reference.verify(speed=options.speed)  # refuses: a person has to look
    guide = TerminalOperator()
    if not guide.prepare(arm, off=False):
        raise OperatorNeeded("not confirmed: nothing moved")
    say(FINE)

    def accept(found: Verified) -> bool:
        if options.accept or options.keep:
            return bool(options.accept)
        say(str(found))
        return sys.stdin.isatty() and agreed("Accept this posture as the new reference? Type yes: ")

    return arm.reference.verify(operator=guide, accept=accept, speed=options.speed)
