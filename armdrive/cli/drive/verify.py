"""Measure how far an arm has drifted: its finger tips on the mark say where it really is.

The arm MOVES to a little above its reference mark. Then you jog the tips onto the mark by small
steps, on lines such as `shoulder -0.5`, and type `done`. What the registers read beyond the
reference posture is told by motor, by joint and at the tip, with what it means, and is written down
with the date in the state folder. A simulated arm has a simulated operator.

It ends with 1 where the arm is off and the posture was not taken for the new reference.
"""

from __future__ import annotations

import argparse
import sys

from armdrive.arm import Arm
from armdrive.cli.arm_options import add_allow_restored, add_arm_options
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.options import fraction
from armdrive.cli.presenter import emit, say, say_which
from armdrive.cli.terminal_person import TerminalOperator, agreed, settle_trust
from armdrive.errors import OperatorNeeded
from armdrive.motion.verify import Verdict, Verified, verified_view

OFF = 1
FINE = "Finer is better here: shoulder 0.1, say. The smallest jog is one step of a motor."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--accept",
        action="store_true",
        help="take the posture at the mark for the new reference, without asking",
    )
    parser.add_argument(
        "--keep", action="store_true", help="measure alone: take nothing for the new reference"
    )
    parser.add_argument("--speed", type=fraction, default=0.5, help="fraction of the limits")
    add_allow_restored(parser)
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Measure, and say what was found."""
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say_which(arm.status)
        settle_trust(arm)
        verified = _verified(arm, options)
        if options.json:
            emit(verified_view(verified))
        else:
            say(str(verified))
            if arm.logbook is not None:
                say(f"written down in {arm.logbook}")
    return 0 if verified.accepted or verified.verdict is Verdict.ROUNDING else OFF


def _verified(arm: Arm, options: argparse.Namespace) -> Verified:
    if arm.simulated:
        return arm.verify(accept=options.accept, speed=options.speed)
    if options.json:
        return arm.verify(speed=options.speed)  # which says that somebody has to look
    guide = TerminalOperator(terminal=False)
    if not guide.prepare(arm, off=False):
        raise OperatorNeeded("nobody agreed: nothing was moved")
    say(FINE)

    def accept(found: Verified) -> bool:
        if options.accept or options.keep:
            return bool(options.accept)
        say(str(found))
        return sys.stdin.isatty() and agreed("Take this posture for the new reference? Type yes: ")

    return arm.verify(operator=guide, accept=accept, speed=options.speed)
