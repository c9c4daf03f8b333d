"""An arm that a person runs something on: its clock, its table, what goes on when it is left."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager

from armdrive.arm import Arm
from armdrive.sim.world.table import TableBlock


def time_s(arm: Arm) -> float:
    """Return the time on an arm's own clock."""
    return arm.pace.now_s()


def between_steps(arm: Arm) -> AbstractContextManager[object]:
    """Let nothing of an arm change while it is looked at."""
    return arm.pace.lock


def silent_time_s(arms: Iterable[Arm]) -> float:
    """Return for how long arms may go on with what they were sent when nothing more comes."""
    return max((arm.core.stop_bound().silent_time_s for arm in arms), default=0.0)


def accept_restored(arm: Arm) -> None:
    """Have an arm trust the position that an earlier program left."""
    arm.core.allow_restored = True


def put_blocks(arm: Arm, blocks: Sequence[TableBlock]) -> None:
    """Put blocks on a simulated table, one after the other, each on what is there already."""
    if arm.twin is None:
        return
    with between_steps(arm):
        for block in blocks:
            arm.twin.world.put(block)
