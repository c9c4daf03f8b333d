"""The simulated operator: somebody who sees the simulated arm and jogs it to where it is asked.

He does what a person would: looks at the physical posture, which no register knows, first lifts
the hand over the mark, then lowers it, in steps of the arm's own motors through the driver. Motors
with backlash he brings there from one side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kinematics import Joints, Motors

if TYPE_CHECKING:
    from armdrive.posture import PostureRequest
    from armdrive.sim.world import World

LIFT_MM = 60.0
LOOKS = 4
SIDE = 2
"""How many times its backlash he turns a motor away, and back again."""
SEEN_RAD = math.radians(1.0)
"""How well he can see whether an arm stands as it is drawn."""


@dataclass(frozen=True, slots=True)
class SimulatedOperator:
    """Answers `home` for a simulated arm. He cannot lift an arm whose motors have no current."""

    world: World
    speed: float = 1.0

    def __call__(self, request: PostureRequest) -> bool:
        """Bring the arm to the posture; True when it stands there to the step."""
        arm = request.arm.model.arm
        pose = request.pose
        above = replace(pose, z_mm=pose.z_mm + LIFT_MM)
        self._bring(request, arm.ik(above))
        if widths := request.arm.config.backlash_steps:
            request.arm.move_motors(*(-SIDE * width for width in widths), speed=self.speed)
            request.arm.move_motors(*(SIDE * width for width in widths), speed=self.speed)
        return any(not self._bring(request, request.joints).largest for _ in range(LOOKS))

    def stands_at(self, joints: Joints) -> bool:
        """Compare the physical arm with a drawn posture."""
        return all(
            abs(seen - drawn) <= SEEN_RAD
            for seen, drawn in zip(self.world.joints, joints, strict=True)
        )

    def _bring(self, request: PostureRequest, joints: Joints) -> Motors:
        """Jog towards a posture; return the steps that were missing."""
        transmission = self.world.body.transmission
        missing = transmission.to_motors(joints, request.opening_mm) - self.world.motors
        if missing.largest:
            request.arm.move_motors(*missing, speed=self.speed)
        return missing
