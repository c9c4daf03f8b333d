"""What running a program file and running a script have in common: arms, pictures, ends."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import complain, put, put_error, say
from armdrive.cli.program.run_display import Display
from armdrive.cli.terminal_person import ask_operator, settle_trust
from armdrive.connect.target import Target
from armdrive.errors import ArmError, ArmInUse, BadRequest, DeviceFault, LinkError
from armdrive.errors.table import error_view, tagged
from armdrive.programs.problems import SourceMark, excerpt
from armdrive.runtime.clock import PaceChoice
from armdrive.sim.world.table import TableBlock
from armdrive.status import State, pose_view


def connect_to_run(options: argparse.Namespace, *, pace: PaceChoice = None) -> Arm:
    """Connect to the arm that the options name, and settle whether its position can be trusted."""
    require_table(chosen_target(options), options.put)
    arm = connect_chosen(options, pace=options.pace or pace, allow_restored=options.allow_restored)
    try:
        put_blocks(arm, options.put)
        options.put = []  # once, however often a script connects
        if not options.json:
            say(arm.status.which)
        if arm.simulated or not options.check:
            settle_trust(arm)
        if not arm.simulated and sys.stdin.isatty() and not options.json:
            arm.operator = ask_operator  # for a program that references the arm
    except BaseException:
        arm.close()
        raise
    return arm


def connect_to_check(options: argparse.Namespace) -> tuple[Arm | None, str]:
    """Connect to ask where the arm stands; return why not, where that cannot be."""
    try:
        return connect_to_run(options), ""
    except (LinkError, ArmInUse, DeviceFault) as error:
        which = chosen_target(options).config.title
        return None, f"the {which} cannot be asked where it stands ({error})"


def require_table(target: Target, blocks: list[TableBlock]) -> None:
    """Raise `BadRequest` where blocks are to be put on the table of a real arm."""
    if blocks and not target.simulated:
        raise BadRequest(
            f"--put puts blocks on the table of a simulated arm, and {target.config.name} is a "
            "real one: lay them out by hand"
        )


def put_blocks(arm: Arm, blocks: list[TableBlock]) -> None:
    """Put blocks on the table, one after the other, each on what is there already."""
    if arm.twin is None:
        return
    with arm.pace.lock:
        for block in blocks:
            arm.twin.world.put(block)


def make_ready(arm: Arm, options: argparse.Namespace) -> None:
    """Switch an arm on that is about to be moved, and slow it down as asked for."""
    if arm.status.state is State.DISABLED:
        arm.enable()
    slow_down(arm, options)


def slow_down(arm: Arm, options: argparse.Namespace) -> None:
    """Have an arm go no faster than the person wants. Raises `BadRequest`."""
    if options.speed is not None:
        arm.speed_override = options.speed / 100.0


def display_for(options: argparse.Namespace, lines: list[str]) -> Display:
    """Return what shows the run, as the person or the program that reads it wants it."""
    output = sys.stdout  # kept: what a script prints may be led elsewhere meanwhile

    def write(event: dict[str, Any]) -> None:
        put(f"{json.dumps(event)}\n", output=output)

    return Display(lines, write if options.json else None, rewrites=output.isatty())


def show_place(mark: SourceMark | None, lines: list[str], error: BaseException) -> None:
    """Show a line of the program with a caret under the place, where the error does not do so."""
    if mark is None or getattr(error, "mark", None) is not None:
        return
    put_error(f"{mark}\n")
    if 0 < mark.line <= len(lines):
        put_error(f"{excerpt(lines[mark.line - 1], mark.column)}\n")


def failed_view(mark: SourceMark | None, error: BaseException, resume: str) -> dict[str, Any]:
    """Return the end of a run that did not end well, as plain data."""
    return {
        "event": "failed",
        "line": None if mark is None else mark.line,
        "column": None if mark is None else mark.column,
        "error": error_view(error),
        "resume": resume or None,
    }


def stands_at(arm: Arm) -> str:
    """Say where an arm stands, as far as anybody knows."""
    status = arm.status
    return "nobody knows where the arm stands" if status.pose is None else f"tip {status.pose}"


def ended_view(arm: Arm | None, acts: int, took_s: float) -> dict[str, Any]:
    """Return the end of a run that went well, as plain data."""
    pose = None if arm is None else pose_view(arm.status.pose)
    return {"event": "end", "acts": acts, "took_s": round(took_s, 3), "pose": pose}


def keep_recording(arm: Arm, options: argparse.Namespace) -> None:
    """Write the recording of a run, if one is wanted; how the run ended counts for more."""
    if options.record is None:
        return
    try:
        arm.save_recording(options.record)
    except ArmError as error:
        complain(f"armdrive: {tagged(error)}")
