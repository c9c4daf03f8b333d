"""A shaft that was blocked and comes free goes to its set-point, until its drive is told to hold.

A drive whose shaft is blocked in a motion has a set-point that is ahead of the shaft. The driver
finds that within `TOLD_S` and tells it to hold where its shaft is. Of a drive that is not heard,
nobody knows where that is: where it was heard last is behind a shaft that has gone on, and would be
driven back to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

CATCHES_UP_S = 0.1
"""So soon a shaft that is free again is at its set-point."""
TOLD_S = 0.7
"""So long after a shaft was blocked in a motion its drive holds where the shaft is: it is found
within 0.6 s (docs/controllers/mks.md, docs/controllers/can.md), and relieved in 0.1 s."""


@dataclass(slots=True)
class Freed:
    """What is excused of motors, counted from 0, that come free before their drives hold."""

    hears: Callable[[int, float], bool] = lambda _motor, _time_s: True
    """Whether a program hears a motor's drive, at a time in s."""
    _blocked_s: dict[int, float] = field(default_factory=dict)
    """When a motor was blocked last whose drive does not hold yet."""
    _until_s: dict[int, float] = field(default_factory=dict)
    """When the drive of a motor that was blocked in a motion is told to hold."""

    def blocked(self, motors: Collection[int], time_s: float, *, in_motion: bool = False) -> None:
        """Hear of motors that are driven, and do not turn; `in_motion` where they are to move."""
        for motor in motors:
            if in_motion and time_s > self._blocked_s.get(motor, -math.inf) + CATCHES_UP_S:
                self._until_s[motor] = time_s + TOLD_S
            if not self.hears(motor, time_s) or time_s <= self._until_s.get(motor, -math.inf):
                self._blocked_s[motor] = time_s

    def excuses(self, motors: Collection[int], time_s: float) -> bool:
        """Tell whether nothing turns but such motors, a moment after they were blocked."""
        return all(
            time_s <= self._blocked_s.get(motor, -math.inf) + CATCHES_UP_S for motor in motors
        )
