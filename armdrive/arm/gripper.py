"""The gripper of an arm, as a program sees it."""

from __future__ import annotations

from armdrive.arm.moving import MoveCalls
from armdrive.errors import Refused
from armdrive.errors.arguments import BASIC, checked_calls
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped, grasp, require_gripper
from armdrive.motion.plan import speed_fraction
from armdrive.runtime.states import Event, after
from armdrive.trace.calls import witnessed
from kinematics.errors import finite

GRASP_PATIENCE_S = 120.0
"""A grasp that takes longer is given up."""


@witnessed
@checked_calls(BASIC)
class Gripper:
    """The fingers of an arm."""

    def __init__(self, arm: MoveCalls) -> None:
        self._arm = arm

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers are: where the motors have them, or what keeps them apart.

        Raises `NotReferenced` while the position is unknown, and `Refused` for a servo that has
        not been commanded yet.
        """
        core = self._arm.core
        require_gripper(core)
        if not core.transmission.has_gripper and core.gripper_share is None:
            raise Refused("nobody knows how the gripper stands: open or close it first")
        return self._arm.known(self._arm.status.gripper_mm)

    @property
    def force_n(self) -> float:
        """The force of the grasp, from the steps behind the touch; 0 when let go."""
        return self._arm.core.grip_force_n

    def open(self, opening_mm: float | None = None, *, speed: float = 1.0) -> Moved:
        """Open to a width in mm, or all the way."""
        require_gripper(self._arm.core)
        widest = self._arm.model.gripper_range_mm[1]
        return self.move(widest if opening_mm is None else opening_mm, speed=speed)

    def close(self, opening_mm: float = 0.0, *, speed: float = 1.0) -> Moved:
        """Close to a width in mm without feeling for an object; see `grasp`."""
        return self.move(opening_mm, speed=speed)

    def move(self, opening_mm: float, *, speed: float = 1.0) -> Moved:
        """Bring the fingers to an opening in mm."""
        return self._arm.move_gripper(finite("opening_mm", opening_mm), speed_fraction(speed))

    def grasp(self, *, force_n: float = 8.9) -> float:
        """Close on whatever is between the fingers; return its width in mm, 0.0 for nothing.

        `force_n` (about 2 lb by default) is pressed after the grip switch has tripped.
        """
        return self.feel(force_n=force_n).width_mm

    def feel(self, *, force_n: float = 8.9) -> Grasped:
        """Like `grasp`, and also tell the force."""
        arm = self._arm
        require_gripper(arm.core)
        if not arm.abilities.grip_switch:
            raise Refused(
                "this arm has no grip switch: close the fingers to a width instead, with "
                "gripper.close(WIDTH), in a program file with open_now WIDTH"
            )
        force = finite("force_n", force_n)
        with arm.pace.lock:
            arm.core.require_reference()
            after(arm.core.state, Event.MOVE)
            task = arm.submit(grasp(arm.wire, arm.speeds, force), alone=True)
        return arm.finish(task, GRASP_PATIENCE_S)
