"""The gripper of an arm, as a program sees it."""

from __future__ import annotations

from typing import Protocol, overload

from armdrive.arm.connected import Handle, finished
from armdrive.blocking import blocking, coroutine_of
from armdrive.connect.parts import Parts
from armdrive.errors import Refused
from armdrive.errors.arguments import BASIC, checked_calls
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped, require_gripper
from armdrive.moves import GraspMove, GripperMove, Motion
from armdrive.trace.calls import Tracer, traced


class TracedArm(Protocol):
    """The arm that the fingers belong to: its calls are traced, and theirs with them."""

    tracer: Tracer

    @overload
    def start(self, move: Motion) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove) -> Handle[Grasped]: ...
    def start(self, move: Motion | GraspMove) -> Handle[Moved] | Handle[Grasped]:
        """Begin a move."""


@traced
@checked_calls(BASIC)
class Gripper:
    """The fingers of an arm."""

    def __init__(self, arm: TracedArm, parts: Parts) -> None:
        self._arm = arm
        self._parts = parts

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers are: where the motors have them, or what keeps them apart.

        Raises `NotReferenced` while the position is unknown, and `Refused` for a servo that has
        not been commanded yet.
        """
        core = self._parts.core
        require_gripper(core)
        if not core.transmission.has_gripper and core.fingers.share is None:
            raise Refused("nobody knows how the gripper stands: open or close it first")
        return self._parts.known(self._parts.status.gripper_mm)

    @property
    def force_n(self) -> float:
        """The force of the grasp, from the steps behind the touch; 0 when let go."""
        core = self._parts.core
        return core.fingers.force_n(core.position.coordinates.opening_mm)

    @blocking
    async def open(self, opening_mm: float | None = None, *, speed: float = 1.0) -> Moved:
        """Open to a width in mm, or all the way."""
        return await finished(self._arm.start(GripperMove(opening_mm, speed)))

    @blocking
    async def close(self, opening_mm: float = 0.0, *, speed: float = 1.0) -> Moved:
        """Close to a width in mm without feeling for an object; see `grasp`."""
        return await coroutine_of(self.move)(opening_mm, speed=speed)

    @blocking
    async def move(self, opening_mm: float, *, speed: float = 1.0) -> Moved:
        """Bring the fingers to an opening in mm."""
        return await finished(self._arm.start(GripperMove(opening_mm, speed)))

    @blocking
    async def grasp(self, *, force_n: float = 8.9) -> float:
        """Close on whatever is between the fingers; return its width in mm, 0.0 for nothing.

        `force_n` (about 2 lb by default) is pressed after the grip switch has tripped.
        """
        return (await coroutine_of(self.feel)(force_n=force_n)).width_mm

    @blocking
    async def feel(self, *, force_n: float = 8.9) -> Grasped:
        """Like `grasp`, and also tell the force."""
        return await finished(self._arm.start(GraspMove(force_n)))
