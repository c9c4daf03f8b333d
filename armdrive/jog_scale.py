"""How much of a wished jog joints and motors can do from where the arm is, all axes slowed alike.

Near a singularity a line of the tip asks more and more of the joints. What a leg asks is measured
by solving it; of the five-axis build its joint rates are the first guess.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from armdrive.intents import CARTESIAN_AXES, GRIPPER_AXIS, YAW_AXIS, Space
from kinematics import FiveAxisArm
from kinematics.five_axis.jog_rates import Rates, joint_rates, share_of_limits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from armdrive.armfile import ArmConfig
    from armdrive.jog_ways import Way
    from armdrive.legs import Speeds
    from armdrive.whereabouts import Coordinates

ANGULAR_JOG_RAD_S = math.radians(45.0)
"""Pitch, roll and yaw of a Cartesian jog at full speed, before the joints' limits slow it."""

TRIES = 12
NEARLY = 0.93
"""A leg that needs this share of its time, or all of it, is as fast as can be."""
EXACTLY = 1.0 + 1e-9
LEAST, MOST = 0.05, 4.0
"""By what factor a guess is corrected at once."""


def axis_names(config: ArmConfig, space: Space) -> tuple[str, ...]:
    """Return the axes of a jog in a space, the gripper last."""
    if space is Space.JOINT:
        return (*config.model.arm.joint_names, GRIPPER_AXIS)
    yaw = (YAW_AXIS,) if config.model.arm.has_yaw else ()
    return (*CARTESIAN_AXES, *yaw, GRIPPER_AXIS)


class Scale:
    """Full speeds of the axes, and what can be had of them."""

    def __init__(self, config: ArmConfig, speeds: Speeds) -> None:
        self._arm = config.model.arm
        self._speeds = speeds
        yaw = (ANGULAR_JOG_RAD_S,) * self._arm.has_yaw
        tip = (config.motion.tip_speed_mm_s,) * 3
        self._full: dict[Space, Rates] = {
            Space.JOINT: (*speeds.joints_rad_s, speeds.gripper_mm_s),
            Space.CARTESIAN: (
                *tip,
                ANGULAR_JOG_RAD_S,
                ANGULAR_JOG_RAD_S,
                *yaw,
                speeds.gripper_mm_s,
            ),
        }

    def full(self, space: Space) -> Rates:
        """Return full speed in rad/s and mm/s."""
        return self._full[space]

    def first_guess(self, start: Coordinates, rates: Sequence[float], speed: float) -> float:
        """Return what the joint rates alone allow of a tip's rates, 1 where nobody knows."""
        if not isinstance(self._arm, FiveAxisArm):
            return 1.0
        angles = start.joints.angles_rad
        found = joint_rates(angles, rates[:-1], self._arm.lengths)  # type: ignore[arg-type]
        if found is None:
            return 1.0
        return share_of_limits(found, [limit * speed for limit in self._speeds.joints_rad_s])

    def share(
        self,
        way: Way,
        start: Coordinates,
        time_s: float,
        speed: float,
        guess: float,
    ) -> float:
        """Return the share of a way's speed with which a leg of `time_s` keeps all limits.

        Limits are those of `speed`. Where nothing but a little can be solved, a little is given.
        """
        share = guess
        known = 0.0
        for _ in range(TRIES):
            there = way.at(time_s * share)
            if there is None:
                share = max(share / 2.0, known)
                if share == known:
                    break
                continue
            need_s = self._speeds.duration_s(start, there, speed)
            if need_s <= time_s * EXACTLY:
                known = max(known, share)
                if share >= 1.0 or need_s >= NEARLY * time_s:
                    break
            share *= min(max(0.97 * time_s / need_s if need_s else MOST, LEAST), MOST)
            share = min(share, 1.0)
        return known or share
