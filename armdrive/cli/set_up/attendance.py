"""Who takes part in a dialog about an arm: the person at the terminal, or a simulated person."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from armdrive.cli.presenter import as_json, say, tell
from armdrive.cli.questions import TerminalPerson, ask_yes_no
from armdrive.connect.target import simulation_forced
from armdrive.errors import OperatorNeeded
from armdrive.setup.filing import FileProposal
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.simulated_arm import SimulatedArm


@dataclass(frozen=True, slots=True)
class Attendance:
    """Whether the arm is `simulated`, and whether its simulated person answers `alone`."""

    simulated: bool
    alone: bool
    tell: Callable[[str], None]

    def simulated_person(self, twin: SimulatedArm) -> SimulatedPerson:
        """Return who handles and watches a simulated arm, and answers or asks at the terminal."""
        # no command continues from a question: nothing is kept of a simulated arm
        return SimulatedPerson(twin, self.tell, None if self.alone else TerminalPerson().answer)

    def write_down(self, proposal: FileProposal) -> None:
        """Write a change that was shown, if the user agrees; for a simulated arm write nothing."""
        if self.simulated or not proposal.differs:
            return
        if ask_yes_no(f"Write this to {proposal.path}?", "no leaves the file unchanged.", "yes"):
            proposal.write()
            say(f"written: {proposal.path}")


def is_simulated(options: argparse.Namespace) -> bool:
    """Return whether a dialog is about a simulated arm, so that nothing is written."""
    return options.sim or simulation_forced()


def attendance(options: argparse.Namespace, needed: str) -> Attendance:
    """Return who takes part, as the options say.

    Raises `OperatorNeeded` for a real arm without a person at a terminal, who is `needed` there.
    """
    simulated = is_simulated(options)
    alone = options.yes or as_json(options)
    if not simulated and (alone or not sys.stdin.isatty()):
        raise OperatorNeeded(
            f"you have to {needed}: run this in a terminal, or give --sim (with --yes or --json it "
            "asks no questions)"
        )
    return Attendance(simulated, alone, partial(tell, options))
