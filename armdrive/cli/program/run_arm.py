"""The arm of a run: how it is connected, what lies on its table, its speed, and its recording."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import as_json, complain, tell
from armdrive.cli.terminal_operator import ask_operator, settle_trust
from armdrive.connect.target import Target
from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import reason_of
from armdrive.errors.table import tagged
from armdrive.runtime.clock import PaceChoice
from armdrive.sim.world.table import TableBlock
from armdrive.storage.files import require_free


def settle_for_run(arm: Arm, options: argparse.Namespace) -> None:
    """Settle whether the position can be trusted, and let a program ask the person at a terminal.

    A check moves nothing, so it asks no question about a real arm.
    """
    if arm.simulated or not options.check:
        settle_trust(arm)
    if not arm.simulated and sys.stdin.isatty() and not as_json(options):
        arm.operator = ask_operator  # for a program that references the arm


def connect_to_run(
    options: argparse.Namespace,
    *,
    pace: PaceChoice = None,
    settle: Callable[[Arm, argparse.Namespace], None] = settle_for_run,
) -> Arm:
    """Connect to the arm that the options name, as slow and with such a table as they say."""
    if options.put:
        _require_table(chosen_target(options))
    arm = connect_chosen(options, pace=options.pace or pace)
    try:
        put_blocks(arm, options.put)
        options.put = []  # once, however often a script connects
        tell(options, arm.status.which)
        settle(arm, options)
        slow_down(arm, options)
    except BaseException:
        arm.close()
        raise
    return arm


def _require_table(target: Target) -> None:
    """Raise `BadRequest` for a real arm, on whose table no blocks can be put."""
    if not target.simulated:
        raise BadRequest(
            f"--put puts blocks on the table of a simulated arm, and {target.config.name} is a "
            "real one: lay them out by hand"
        )


def put_blocks(arm: Arm, blocks: Sequence[TableBlock]) -> None:
    """Put blocks on a simulated arm's table, one after the other, each on what lies there."""
    if arm.twin is None:
        return
    with arm.parts.pace.lock:
        for block in blocks:
            arm.twin.world.put(block)


def slow_down(arm: Arm, options: argparse.Namespace) -> None:
    """Slow an arm down to the speed that the person asked for."""
    if options.speed is not None:
        arm.speed_override = options.speed


def stands_at(arm: Arm) -> str:
    """Return where an arm stands, as people read it."""
    status = arm.status
    return "the arm's position is unknown" if status.pose is None else f"tip {status.pose}"


def require_recordable(path: Path, *, overwrite: bool) -> None:
    """Raise `BadRequest` if no recording can be written there: after the run it is too late."""
    require_free(path, overwrite=overwrite)
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        reason = reason_of(error)
        raise BadRequest(f"{path} could not be written: {reason}; nothing moved") from None


def keep_recording(arm: Arm, options: argparse.Namespace) -> None:
    """Write the recording of a run, if one is wanted; how the run ended counts for more."""
    if options.record is None:
        return
    try:
        # asked before the run; a script that connects twice writes the same file twice
        arm.recorder.save(options.record, overwrite=True)
    except ArmError as error:
        complain(f"armdrive: {tagged(error)}")
