"""A shaft that was blocked, and comes free while its drive says nothing: it goes to its set-point.

A drive that is stopped while its shaft is blocked holds a set-point that is ahead of the shaft. One
that is heard is told to hold where its shaft is. Of one that is not, nobody knows where that is:
where it was heard last is behind a shaft that has gone on, and would be driven back to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

CATCHES_UP_S = 0.1
"""So soon a shaft that is free again is at its set-point."""


@dataclass(slots=True)
class Freed:
    """What is excused of motors, counted from 0, that come free while nobody hears their drives."""

    hears: Callable[[int, float], bool] = lambda _motor, _time_s: True
    """Whether a program hears a motor's drive, at a time in s."""
    _blocked_s: dict[int, float] = field(default_factory=dict)

    def blocked(self, motors: Collection[int], time_s: float) -> None:
        """Hear of motors that are driven, and do not turn."""
        for motor in motors:
            if not self.hears(motor, time_s):
                self._blocked_s[motor] = time_s

    def excuses(self, motors: Collection[int], time_s: float) -> bool:
        """Tell whether nothing turns but such motors, a moment after they were blocked."""
        return all(
            time_s <= self._blocked_s.get(motor, -math.inf) + CATCHES_UP_S for motor in motors
        )
