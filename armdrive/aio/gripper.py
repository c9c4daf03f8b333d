"""The async twin of an arm's gripper."""

from __future__ import annotations

from armdrive.aio.twins import Twin, awaited
from armdrive.gripper import Gripper


class AsyncGripper(Twin[Gripper]):
    """The fingers of an arm: the calls of `Gripper`, awaited."""

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers are; see `Gripper.opening_mm`."""
        return self.sync.opening_mm

    @property
    def force_n(self) -> float:
        """The force of the grasp; 0 when let go."""
        return self.sync.force_n

    open = awaited(Gripper.open)
    close = awaited(Gripper.close)
    move = awaited(Gripper.move)
    grasp = awaited(Gripper.grasp)
    feel = awaited(Gripper.feel)
