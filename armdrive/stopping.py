"""How long and how far the finger tips go on: after a stop, and after the host has fallen silent.

Bounds that hold for any motion. What is under way runs on for as long as the controller says
(a burst that cannot be aborted; what was sent ahead, and a ramp). The tip's way is bounded by
every joint turning at its limit for that long, each at its distance from the tip. A joint's
distance from the tip grows by at most the way that the joints beyond it make meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinematics import Joints

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.controllers.controller import Controller


FASTER = 1.5
"""By what factor motors may be faster than the driver's table of them says."""


@dataclass(frozen=True, slots=True)
class StopBound:
    """The worst case at this moment: of a stop that is asked for, and of a host that dies.

    A pause is to the arm what that death is: what the device was handed runs out, no more comes.
    """

    time_s: float
    distance_mm: float
    silent_time_s: float
    silent_distance_mm: float


def stop_bound(
    config: ArmConfig, controller: Controller, joints: Joints | None, burst_s: float
) -> StopBound:
    """Return the bound at a posture; without a known posture, for the arm stretched out."""
    stopping = controller.stopping(burst_s)
    speeds = _speeds_rad_s(config, controller)
    return StopBound(
        stopping.asked_s,
        _way_mm(config, joints, speeds, stopping.asked_motion_s),
        stopping.silent_s,
        _way_mm(config, joints, speeds, stopping.silent_motion_s),
    )


def _speeds_rad_s(config: ArmConfig, controller: Controller) -> tuple[float, ...]:
    """Return how fast each joint can turn: by its limit, or by motors that are slower than it."""
    limits = config.model.joint_speeds_rad_s
    transmission = config.model.transmission
    if transmission is None:
        return limits
    fastest_hz = controller.usable_rate_hz(math.inf) * FASTER
    turns = (fastest_hz * math.fsum(map(abs, row)) for row in transmission.inverse)
    return tuple(min(limit, turn) for limit, turn in zip(limits, turns, strict=False))


def _way_mm(
    config: ArmConfig, joints: Joints | None, speeds: tuple[float, ...], motion_s: float
) -> float:
    way_mm = 0.0
    for speed_rad_s, lever_mm in reversed(
        list(zip(speeds, config.model.arm.levers_mm(joints), strict=True))
    ):
        if lever_mm > 0.0:
            way_mm += speed_rad_s * motion_s * (lever_mm + way_mm)
    return way_mm


def straying_mm(config: ArmConfig, joints: Joints, steps: Sequence[float]) -> float:
    """Bound how far the tip leaves its way when each motor may stray from it by so many steps."""
    transmission = config.model.transmission
    if transmission is None or not any(steps):
        return 0.0
    turns_rad = (
        math.fsum(abs(share) * one for share, one in zip(row, steps, strict=True))
        for row in transmission.inverse
    )
    levers_mm = config.model.arm.levers_mm(joints)
    return math.fsum(turn * lever for turn, lever in zip(turns_rad, levers_mm, strict=False))
