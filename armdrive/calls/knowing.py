"""What is known of a connected arm: its status, its model, its speeds, its frames."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar

from armdrive.errors import ArmError
from armdrive.frames import frame_names, pose_in_frame
from armdrive.legs import Speeds
from kinematics import ArmModel, Joints, Pose

if TYPE_CHECKING:
    from armdrive.abilities import Abilities
    from armdrive.armfile import ArmConfig
    from armdrive.core import Core
    from armdrive.engine import Engine
    from armdrive.pace import Pace
    from armdrive.status import Status

T = TypeVar("T")


class Knowing:
    """The calls that ask and wait for nothing; `Connected` makes what they look at."""

    config: ArmConfig
    core: Core
    engine: Engine
    pace: Pace
    simulated: bool

    @property
    def status(self) -> Status:
        """A frozen picture of this moment."""
        with self.pace.lock:
            wakes = self.pace.lateness.view()
            return self.core.status(self.engine, simulated=self.simulated, wakes=wakes)

    @property
    def speeds(self) -> Speeds:
        """The limits that time is computed from; a device may tell its own once it is connected."""
        return Speeds(
            self.config.model.joint_speeds_rad_s,
            self.config.model.gripper_speed_mm_s,
            self.core.controller.usable_rate_hz(math.inf),
            self.core.transmission,
            self.config.motion.ramp_s,
            self.config.motion.jerk_s,
            self.config.accelerations_rad_s2,
        )

    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
        return self.config.model

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
        return self.core.controller.abilities

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
        return self.known(self.status.joints)

    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
        return self.known(self.status.pose)

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames that goals and jogs can be meant in: base, tool, and the arm file's."""
        return frame_names(self.config)

    def pose_in(self, frame: str) -> Pose:
        """The acknowledged pose as the base or a frame of the arm file sees it."""
        return pose_in_frame(self.config, self.pose, frame)

    def known(self, value: T | None) -> T:
        """Return what a status tells, or raise `NotReferenced` where it tells nothing."""
        if value is None:
            self.core.require_reference()
            raise ArmError("the position is not known")
        return value
