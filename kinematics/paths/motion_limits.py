"""What a timed path must keep: limits of every coordinate, and of every motor after the couplings.

Coordinates are joints in rad and, where the gripper moves, its opening in mm; times in s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul

from kinematics.errors import KinematicsError, finite

Point = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Limits of each coordinate (per s, per s^2), and of all motors (steps/s).

    `accelerations` may be infinite, and are if none are given. `jerk_s` is the time in which an
    acceleration builds up; 0 lets it jump. `motors` holds a row for each motor, its steps per
    unit of each coordinate: a transmission's `matrix`. Raises `KinematicsError` and `BadNumber`.
    """

    speeds: tuple[float, ...]
    accelerations: tuple[float, ...] = ()
    jerk_s: float = 0.0
    motors: tuple[tuple[float, ...], ...] = ()
    motor_hz: float = math.inf

    def __post_init__(self) -> None:
        count = len(self.speeds)
        if not self.accelerations:
            object.__setattr__(self, "accelerations", (math.inf,) * count)
        for speed in self.speeds:
            _more_than_nothing("a speed limit", finite("a speed limit", speed))
        for acceleration in self.accelerations:
            _more_than_nothing("an acceleration limit", acceleration)
        _more_than_nothing("motor_hz", self.motor_hz)
        if finite("jerk_s", self.jerk_s) < 0.0:
            raise KinematicsError(f"jerk_s must not be less than 0, not {self.jerk_s!r}")
        if any(len(row) != count for row in (self.accelerations, *self.motors)):
            raise KinematicsError(
                f"{count} coordinates have a speed limit, so as many accelerations are needed, "
                "and as many numbers in each motor's row"
            )

    @property
    def ramps(self) -> bool:
        """Whether anything takes time to reach its speed."""
        return any(limit < math.inf for limit in self.accelerations)

    def least_s(self, change: Sequence[float]) -> float:
        """Return the least time for a straight way at full speed: nothing exceeds its limit."""
        slowest = max(map(_share, change, self.speeds))
        busiest = max((abs(sum(map(mul, row, change))) for row in self.motors), default=0.0)
        return max(slowest, busiest / self.motor_hz)


def _share(change: float, limit: float) -> float:
    return abs(change) / limit


def _more_than_nothing(name: str, limit: float) -> None:
    if not limit > 0.0:
        raise KinematicsError(f"{name} must be more than 0, not {limit!r}")
