"""How long and how far the finger tips go on after a stop: a bound that holds for any motion.

On a device that cannot abort, the burst under way runs to its end. Its length in time is the
burst length of the arm file; the tip's way is bounded by every joint turning at its limit for
that long, each at its distance from the tip. A joint's distance from the tip grows by at most the
way that the joints beyond it make meanwhile.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinematics import Joints

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.controllers.requests import Controller


@dataclass(frozen=True, slots=True)
class StopBound:
    """The worst case of a stop at this moment."""

    time_s: float
    distance_mm: float


def stop_bound(
    config: ArmConfig, controller: Controller, joints: Joints | None, burst_s: float
) -> StopBound:
    """Return the bound at a posture; without a known posture, for the arm stretched out."""
    way_mm = 0.0
    speeds = config.model.joint_speeds_rad_s
    for speed_rad_s, lever_mm in reversed(
        list(zip(speeds, config.model.arm.levers_mm(joints), strict=True))
    ):
        if lever_mm > 0.0:
            way_mm += speed_rad_s * burst_s * (lever_mm + way_mm)
    return StopBound(burst_s + controller.stop_overhead_s(), way_mm)
