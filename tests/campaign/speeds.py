"""The law of speeds: no joint of the physical arm turns faster than its limit or the request."""

import math
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field

from kinematics import Joints

WINDOW_S = 0.2
"""The shortest time over which a speed is averaged: motors make whole steps, seen at moments."""
SPEED_TOLERANCE = 1.2
"""By what factor a joint may exceed its limit: devices have tables of speeds, and motors that are
not coordinated catch up."""


@dataclass(slots=True)
class SpeedWatch:
    """The joint angles of the last `WINDOW_S`, and the speeds that they may show. Seconds, rad."""

    limits_rad_s: tuple[float, ...]
    rounding_rad: tuple[float, ...]
    """How far each joint turns if every motor makes one step."""
    slowest_rad_s: tuple[float, ...]
    """How fast each joint turns at the slowest speed that the device has."""
    rounding_up_rad_s: tuple[float, ...] = ()
    """How much faster each joint turns because drives that catch up round their speeds up."""
    _seen: deque[tuple[float, Joints]] = field(default_factory=deque)

    def forget(self) -> None:
        """Forget the angles: no command made the last motion."""
        self._seen.clear()

    def violation(
        self,
        time_s: float,
        joints: Joints,
        share: float,
        free: Collection[str],
    ) -> str:
        """Return what is wrong with the joints' speeds; empty if nothing is.

        Each may turn at a share of its limit, or at the slowest speed that the device has. Joints
        that are `free` are not judged.
        """
        seen = self._seen
        if seen and seen[-1][0] == time_s:
            seen.pop()  # a long motion is reported in pieces with the same time
        seen.append((time_s, joints))
        while len(seen) > 1 and seen[1][0] <= time_s - WINDOW_S:
            seen.popleft()
        began_s, before = seen[0]
        since_s = time_s - began_s
        if since_s < WINDOW_S:
            return ""
        for name, a, b, limit, rounding, slowest, rounding_up in zip(
            joints.names,
            before,
            joints,
            self.limits_rad_s,
            self.rounding_rad,
            self.slowest_rad_s,
            self.rounding_up_rad_s or (0.0,) * len(joints),
            strict=True,
        ):
            most_rad_s = max(share * limit, min(slowest, limit))
            most_rad = (SPEED_TOLERANCE * most_rad_s + rounding_up) * since_s + rounding
            if name not in free and abs(b - a) > most_rad:
                speed = math.degrees(abs(b - a) / since_s)
                return (
                    f"the {name} turned at {speed:.1f} degrees a second for {since_s:.2f} s, and "
                    f"its limit is {math.degrees(limit):.1f}, of which {share:.0%} were asked for"
                )
        return ""
