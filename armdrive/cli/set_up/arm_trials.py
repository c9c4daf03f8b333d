"""Tries a connected arm: the directions of its motors, and its limit switches.

Also who takes part in such a dialog: the person at the terminal, or a simulated person.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.arm_files import path_of
from armdrive.cli.presenter import Result, as_json, say, tell
from armdrive.cli.questions import TerminalPerson, ask_yes_no
from armdrive.cli.terminal_operator import posture_pictures
from armdrive.config.arm import ArmConfig, limit_remarks
from armdrive.connect import parts
from armdrive.connect.target import simulation_forced
from armdrive.dialog import Dialog
from armdrive.errors import OperatorNeeded
from armdrive.registry.arm_files import load_arm
from armdrive.setup.arm_checks import (
    SawSwitch,
    all_work,
    check_switches,
    find_signs,
    make_ready,
    record,
    switches_of,
)
from armdrive.setup.filing import FileProposal, propose
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.sim.world.body import found_posture
from armdrive.storage.files import require_writable


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


@contextlib.contextmanager
def trial_arm(config: ArmConfig, *, simulated: bool) -> Iterator[Arm]:
    """Open an arm for a trial, with its motors as they are."""
    # as it is: `with arm` would switch the motors on before anyone has agreed
    open_arm = parts.connect_simulated if simulated else parts.connect_real
    with contextlib.closing(Arm(open_arm(config))) as arm:
        yield arm


def _dialog(arm: Arm, attended: Attendance) -> Dialog:
    """Return the dialog with the person who handles and watches an arm."""
    if arm.twin is None or not arm.simulated:
        return Dialog(TerminalPerson())
    return Dialog(attended.simulated_person(arm.twin))


def _to_change(options: argparse.Namespace) -> tuple[Path, ArmConfig]:
    """Return the arm file that is to be changed, and its arm.

    Raises `OSError` if it could not be written after the trial.
    """
    path = path_of(options.name)
    config = load_arm(path)
    if not is_simulated(options):
        require_writable(path.parent)  # before a person and the motors work for nothing
    return path, config


def signs(options: argparse.Namespace) -> Iterator[Result]:
    """Find which way the motors count, and write that to the arm file if the user agrees."""
    path, config = _to_change(options)
    attended = attendance(options, "watch a real arm while its motors turn")
    with trial_arm(config, simulated=attended.simulated) as arm:
        picture = posture_pictures(arm, found_posture(arm.model.arm), 30.0)
        found = find_signs(_dialog(arm, attended), arm, picture)
    proposal = propose(path, config.model.transmission, found)
    view = {
        "reversed_motors": list(found.motors),
        "reversed_joints": list(found.joints),
        "unclear": list(found.unclear),
        "moved_times_too_far": dict(found.farther),
        "lines": list(proposal.difference),
    }
    right = () if proposal.differs or proposal.remarks else ("every direction is correct",)
    lines = (*proposal.difference, *proposal.remarks, *right)
    yield Result(view, lines, 1 if found.unclear else 0)
    attended.write_down(proposal)


UNHEEDED = (
    "A switch that closes in motion would stop nothing: the board's firmware ignores hard limits, "
    "as the default build of grbl-Mega-5X for RAMPS boards does. Use another build "
    "(docs/controllers/grbl.md), or write hard_limits = false."
)


def limits(options: argparse.Namespace) -> Iterator[Result]:
    """Check each limit switch, and write the day to the arm file if all work."""
    path, config = _to_change(options)
    switches = switches_of(config)
    attended = attendance(options, "press the switches of a real arm")
    with trial_arm(config, simulated=attended.simulated) as arm:
        make_ready(arm)
        seen = check_switches(_dialog(arm, attended), arm, switches)
    works = all_work(seen)
    view = {"switches": {name: saw.name.lower() for name, saw in seen.items()}, "works": works}
    lines = [f"{name}: {saw.value}" for name, saw in seen.items()]
    if not works:
        unheeded = SawSwitch.PIN_ALONE in seen.values()
        lines.append(UNHEEDED if unheeded else "Check the switches and their wires.")
        yield Result(view, (*lines, *limit_remarks(config)), 1)
        return
    proposal = record(path, config, datetime.now(UTC).astimezone().date())
    if attended.simulated:
        lines.append("every switch works; for a simulated arm nothing is written")
    else:
        lines += proposal.difference
    yield Result(view, lines)
    attended.write_down(proposal)
