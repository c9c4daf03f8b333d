"""The gripper calls of an arm."""

from __future__ import annotations

from typing import Protocol, overload

from armdrive.arm.connected import Handle, finished
from armdrive.blocking import blocking, coroutine_of
from armdrive.connect.parts import Parts
from armdrive.errors import Refused
from armdrive.errors.arguments import BASIC, checked_calls, known_attributes
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped, require_gripper
from armdrive.moves import GraspMove, GripperMove, Motion
from armdrive.trace.calls import Tracer, traced


class TracedArm(Protocol):
    """The gripper's arm, whose tracer also records the gripper's calls."""

    tracer: Tracer

    @overload
    def start(self, move: Motion) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove) -> Handle[Grasped]: ...
    def start(self, move: Motion | GraspMove) -> Handle[Moved] | Handle[Grasped]:
        """Start a move."""


@known_attributes
@traced
@checked_calls(BASIC)
class Gripper:
    """The gripper of an arm."""

    def __init__(self, arm: TracedArm, parts: Parts) -> None:
        self._arm = arm
        self._parts = parts

    @property
    def opening_mm(self) -> float:
        """The distance between the fingers, from the motors or the width of a gripped object.

        Raises `NotReferenced` while the position is unknown, and `Refused` for a servo that has
        not been commanded yet.
        """
        core = self._parts.core
        require_gripper(core)
        if not core.transmission.has_gripper and core.fingers.share is None:
            raise Refused("the gripper's opening is unknown: open or close the gripper first")
        return self._parts.known(self._parts.status.gripper_mm)

    @property
    def force_n(self) -> float:
        """The gripping force, computed from the motor steps after contact; 0 without a grasp."""
        core = self._parts.core
        return core.fingers.force_n(core.position.coordinates.opening_mm)

    @blocking
    async def open(self, opening_mm: float | None = None, *, speed: float = 1.0) -> Moved:
        """Open the fingers to a width in mm, or all the way."""
        return await finished(self._arm.start(GripperMove(opening_mm, speed)))

    @blocking
    async def close(self, opening_mm: float = 0.0, *, speed: float = 1.0) -> Moved:
        """Close the fingers to a width in mm. To detect an object, use `grasp`."""
        return await coroutine_of(self.move)(opening_mm, speed=speed)

    @blocking
    async def move(self, opening_mm: float, *, speed: float = 1.0) -> Moved:
        """Move the fingers to an opening in mm."""
        return await finished(self._arm.start(GripperMove(opening_mm, speed)))

    @blocking
    async def grasp(self, *, force_n: float = 8.9) -> float:
        """Close the fingers on an object; return its width in mm, or 0.0 if there is none.

        The force, about 2 lb by default, is applied after the grip switch has tripped.
        """
        return (await coroutine_of(self.feel)(force_n=force_n)).width_mm

    @blocking
    async def feel(self, *, force_n: float = 8.9) -> Grasped:
        """Grasp an object like `grasp`, and return the force as well."""
        return await finished(self._arm.start(GraspMove(force_n)))
