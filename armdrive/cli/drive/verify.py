"""Measure how far an arm has drifted: its finger tips on the mark say where it really is."""

from __future__ import annotations

import argparse
import sys

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import emit, say
from armdrive.cli.screens import agreed
from armdrive.cli.terminal_person import TerminalOperator, settle_trust
from armdrive.errors import OperatorNeeded
from armdrive.motion.reference import Verdict, Verified, verified_view

OFF = 1
FINE = "Finer is better here: shoulder 0.1, say. The smallest jog is one step of a motor."


def run(options: argparse.Namespace) -> int:
    """Measure, and say what was found."""
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say(arm.status.which)
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
