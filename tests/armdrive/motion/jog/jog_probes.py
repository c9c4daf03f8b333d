"""Where a simulated arm physically is beside the bounds of its jog: beyond them, or before them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from armdrive import Jog
from armdrive.config.arm import ArmConfig
from armdrive.motion.frames import axes_of
from armdrive.moves import CARTESIAN_AXES, GRIPPER_AXIS, Space
from armdrive.runtime.position import ArmCoordinates
from kinematics import Joints, Pose

GRID_MM, GRID_RAD = 0.02, math.radians(0.02)
GRID_POINTS = 800


class Probe:
    """Measures postures of one arm."""

    def __init__(self, config: ArmConfig) -> None:
        self.config = config
        self.geometry = config.model.arm
        self.guarded = config.model.guards.over(self.geometry)
        self.transmission = config.model.transmission

    def over_steps(self, joints: Joints) -> float:
        """Return how many steps the physical arm is beyond the bound that it passes furthest."""
        found = [0.0]
        for bounds, row, angle in zip(
            self.geometry.limits, self.transmission.inverse, joints, strict=False
        ):
            found.append(abs(angle - bounds.clamp(angle)) / sum(map(abs, row)))
        beyond_mm = -self.guarded.room_mm(joints)
        found.append(beyond_mm / self._step_mm(joints))
        return max(found)

    def _step_mm(self, joints: Joints) -> float:
        """Return how far the tip travels at most by one step of every motor."""
        levers = self.geometry.levers_mm(joints)
        rows = zip(self.transmission.inverse, levers, strict=False)
        return sum(sum(map(abs, row)) * lever for row, lever in rows)

    def left_steps(self, jog: Jog, joints: Joints, opening_mm: float) -> float | None:
        """Return how many steps the arm could go on as it was going; None where it is very far."""
        here = ArmCoordinates(joints, opening_mm)
        furthest = here
        for there in self.onwards(jog, here):
            if there is None or self.config.model.guards.violations(self.geometry, there.joints):
                exact = self.transmission.to_exact(furthest.joints, furthest.opening_mm)
                before = self.transmission.to_exact(joints, opening_mm)
                return max(abs(b - a) for a, b in zip(before, exact, strict=True))
            furthest = there
        return None

    def onwards(
        self, jog: Jog, here: ArmCoordinates, grid_mm: float = GRID_MM
    ) -> Iterator[ArmCoordinates | None]:
        if jog.space is Space.JOINT:
            yield from self._joints_onwards(jog, here)
            return
        arm, pose = self.geometry, self.geometry.fk(here.joints)
        axes = axes_of(self.config, here.joints, jog.frame)
        amounts = [jog.amount(name) for name in CARTESIAN_AXES]
        x, y, z = (sum(a * v[i] for a, v in zip(amounts, axes, strict=False)) for i in range(3))
        turn = math.radians(45.0) / self.config.motion.tip_speed_mm_s
        before = here.joints
        for point in range(1, GRID_POINTS):
            s = point * grid_mm
            goal = Pose(
                pose.x_mm + x * s,
                pose.y_mm + y * s,
                pose.z_mm + z * s,
                pose.pitch_rad + amounts[3] * s * turn,
                pose.roll_rad + amounts[4] * s * turn,
            )
            joints = arm.solve(goal, before)
            if joints is None or math.dist(joints, before) > 0.5:
                yield None
                return
            before = joints
            yield ArmCoordinates(joints, here.opening_mm)

    def _joints_onwards(self, jog: Jog, here: ArmCoordinates) -> Iterator[ArmCoordinates | None]:
        """Yield points until the last of the axes is at its end: the others go on without it."""
        low_mm, high_mm = self.config.model.gripper_range_mm
        limits = self.geometry.limits
        going = {name: amount for name, amount in jog.axes if amount}
        for point in range(1, GRID_POINTS):
            angles, ended = list(here.joints), 0
            opening_mm = here.opening_mm
            for name, amount in going.items():
                if name == GRIPPER_AXIS:
                    wanted = here.opening_mm + amount * point * GRID_MM
                    opening_mm = min(max(wanted, low_mm), high_mm)
                    ended += opening_mm != wanted
                    continue
                index = here.joints.names.index(name)
                wanted = here.joints[index] + amount * point * GRID_RAD
                angles[index] = limits[index].clamp(wanted)
                ended += angles[index] != wanted
            yield ArmCoordinates(Joints(tuple(angles)), opening_mm)
            if ended == len(going):
                yield None
                return
