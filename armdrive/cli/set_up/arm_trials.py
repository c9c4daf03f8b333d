"""Tries a connected arm: the directions of its motors, and its limit switches."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.arm_files import path_of
from armdrive.cli.presenter import Result
from armdrive.cli.questions import TerminalPerson
from armdrive.cli.set_up.attendance import Attendance, attendance, is_simulated
from armdrive.cli.terminal_operator import posture_pictures
from armdrive.config.arm import ArmConfig, limit_remarks
from armdrive.connect import parts
from armdrive.dialog import Dialog
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
from armdrive.setup.directions import Signs
from armdrive.setup.filing import propose
from armdrive.sim.world.body import found_posture
from armdrive.storage.files import require_writable

WATCHED = "watch a real arm while its motors turn"
PRESSED = "press the switches of a real arm"


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


def found_signs(arm: Arm, attended: Attendance) -> Signs:
    """Find which way the motors of an arm count, beginning from a posture that is drawn."""
    picture = posture_pictures(arm, found_posture(arm.model.arm), 30.0)
    return find_signs(_dialog(arm, attended), arm, picture)


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
    attended = attendance(options, WATCHED)
    with trial_arm(config, simulated=attended.simulated) as arm:
        found = found_signs(arm, attended)
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
    attended = attendance(options, PRESSED)
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
