"""What a command that runs a program needs of an arm besides its public calls."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager

from armdrive.arm import Arm
from armdrive.sim.world.table import TableBlock


def time_s(arm: Arm) -> float:
    """Return the time on an arm's own clock."""
    return arm.pace.now_s()


def between_steps(arm: Arm) -> AbstractContextManager[object]:
    """Keep an arm from changing while it is read."""
    return arm.pace.lock


def silent_time_s(arms: Iterable[Arm]) -> float:
    """Return how long arms may keep moving after the last message to them."""
    return max((arm.core.stop_bound().silent_time_s for arm in arms), default=0.0)


def accept_restored(arm: Arm) -> None:
    """Let an arm trust the position restored from the last session."""
    arm.core.allow_restored = True


def put_blocks(arm: Arm, blocks: Sequence[TableBlock]) -> None:
    """Put blocks on a simulated table, one after the other, each on what lies there."""
    if arm.twin is None:
        return
    with between_steps(arm):
        for block in blocks:
            arm.twin.world.put(block)
