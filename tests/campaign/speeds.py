"""How fast the joints of the physical arm turn, against the limits of the arm's model."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field

from kinematics import Joints

WINDOW_S = 0.2
"""A speed is a mean over at least this time: an arm is seen at moments, on whole steps."""
FASTER = 1.2
"""By what factor a joint may be faster than its limit.

A device has a table of speeds, and a motor that is not coordinated with the others catches up.
"""


@dataclass(slots=True)
class SpeedWatch:
    """The joints' angles at the latest moments. Seconds, rad."""

    limits_rad_s: tuple[float, ...]
    rounding_rad: tuple[float, ...]
    """What a step of every motor is worth to each joint."""
    slowest_rad_s: tuple[float, ...]
    """How fast each joint turns at the slowest speed of a device that has none between."""
    setting_rad_s: tuple[float, ...] = ()
    """How much faster each joint turns where drives that catch up round their speeds up."""
    _seen: deque[tuple[float, Joints]] = field(default_factory=deque)

    def forget(self) -> None:
        """Hear that what turned just now was turned by no command."""
        self._seen.clear()

    def too_fast(self, time_s: float, joints: Joints, share: float, free: Collection[str]) -> str:
        """Return what is wrong with how fast the joints turn: each at most at a share of its limit.

        Or as slowly as the device can turn it, in short bursts. Joints that are `free` are not
        judged.
        """
        seen = self._seen
        if seen and seen[-1][0] == time_s:
            seen.pop()  # a long way is looked at in pieces that have one time
        seen.append((time_s, joints))
        while len(seen) > 1 and seen[1][0] <= time_s - WINDOW_S:
            seen.popleft()
        began_s, before = seen[0]
        since_s = time_s - began_s
        if since_s < WINDOW_S:
            return ""
        for name, a, b, limit, rounding, slowest, setting in zip(
            joints.names,
            before,
            joints,
            self.limits_rad_s,
            self.rounding_rad,
            self.slowest_rad_s,
            self.setting_rad_s or (0.0,) * len(joints),
            strict=True,
        ):
            most_rad_s = max(share * limit, min(slowest, limit))
            most_rad = (FASTER * most_rad_s + setting) * since_s + rounding
            if name not in free and abs(b - a) > most_rad:
                speed = math.degrees(abs(b - a) / since_s)
                return (
                    f"the {name} turned at {speed:.1f} degrees a second for {since_s:.2f} s, and "
                    f"its limit is {math.degrees(limit):.1f}, of which {share:.0%} were asked for"
                )
        return ""
