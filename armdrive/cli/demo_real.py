"""The demonstration on a real arm: the person puts the blocks down, and looks where they end."""

from __future__ import annotations

import argparse
import sys

from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.confirming import agreed, ask_operator, settle_trust
from armdrive.cli.output import say, say_which
from armdrive.errors import OperatorNeeded
from armdrive.programs.demo import JOBS, Job, perform


def run_on_real_arm(options: argparse.Namespace) -> int:
    """Have the blocks put down, reference the arm if it is not, and perform."""
    if not sys.stdin.isatty():
        raise OperatorNeeded("on a real arm the demonstration needs a person at a terminal")
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        say_which(arm.status)
        for job in JOBS:
            say(_placing(job))
        say(f"One stop takes up to {arm.status.stop_time_s:.2f} s; Ctrl-C asks for it.")
        if not agreed("Are the blocks in place, and nobody in the arm's reach? Type yes: "):
            raise OperatorNeeded("not confirmed: nothing was moved")
        settle_trust(arm)
        arm.operator = ask_operator
        for each in perform(arm, JOBS, say):
            say(f"block {each.job.name}: measured {each.measured_mm:.1f} mm")
    say("Whether every block stands where it belongs, only you can see.")
    return 0


def _placing(job: Job) -> str:
    x_mm, y_mm, _ = job.from_mm
    return (
        f"Put block {job.name}, {job.width_mm:.0f} mm wide and {job.height_mm:.0f} mm high or "
        f"nearly so, at x {x_mm:.0f}, y {y_mm:.0f} mm (in front of the base axis, to its left)."
    )
