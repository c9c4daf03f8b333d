"""Blocks that are put on the table of a simulated arm before a command begins."""

from __future__ import annotations

from armdrive.arm import Arm
from armdrive.connect.target import Target
from armdrive.errors import BadRequest
from armdrive.sim.world.table import TableBlock


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
