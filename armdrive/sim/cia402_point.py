"""The set-point of one CiA 402 drive: what its motor is able to follow of what it is told.

Increments of the shaft's own, whatever zero was set; seconds; increments a second.
"""

from __future__ import annotations

import math

from armdrive.sim.profile import Piece, Profile, nearest
from armdrive.sim.shaft_point import ShaftPoint


class ServoPoint(ShaftPoint):
    """A point that glides from target to target, no faster than its motor can turn."""

    def __init__(self, at: int) -> None:
        super().__init__(at)
        self._demand: Piece | None = None

    def demand(self, now_s: float) -> int:
        """Return where it was told to be: ahead of where it is, of what it cannot follow."""
        return self.at(now_s) if self._demand is None else nearest(self._demand.at(now_s))

    def glide_to(
        self, target: int, period_s: float, most_rate: float, now_s: float, *, on: bool = False
    ) -> None:
        """Go straight to a target within a period, and stand there; or go `on` beyond it."""
        told, here = self.demand(now_s), self._state(now_s)[0]
        rate = (target - told) / period_s
        self._demand = Piece(now_s, told, rate, 0.0, period_s)
        way = target - here
        able = math.copysign(min(abs(way) / period_s, most_rate), way)
        pieces = [Piece(now_s, here, able, 0.0, abs(way / able) if able else 0.0)]
        if on and able:
            self._demand = Piece(now_s, told, rate, 0.0, math.inf)
            pieces.append(Piece(pieces[0].end_s, target, able, 0.0, math.inf))
        self._profile = Profile(pieces, target)
        self._end_s = max(self._profile.end_s, now_s)

    def hold(self, at: int) -> None:
        """Stand dead at an increment."""
        super().hold(at)
        self._demand = None

    def _begin(self, profile: Profile, now_s: float) -> None:
        super()._begin(profile, now_s)
        self._demand = None
