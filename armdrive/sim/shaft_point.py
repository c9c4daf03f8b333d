"""The set-point of one closed-loop shaft: where it is to be at any moment, without ticking.

Counts of the shaft's own, whatever zero was set; seconds; counts a second.
"""

from __future__ import annotations

import math

from armdrive.sim.profile import Piece, Profile, nearest, standing, to_goal, to_speed

_HALVINGS = 60


class ShaftPoint:
    """It stands, or is under way on a profile from whatever it did before."""

    def __init__(self, at: int) -> None:
        self._profile = standing(at)
        self._end_s = -math.inf

    @property
    def end_s(self) -> float:
        """When it comes to a stand; infinity while it runs without an end."""
        return self._end_s

    @property
    def end(self) -> int:
        """Where it comes to a stand; meaningless while it runs without an end."""
        return nearest(self._profile.end)

    def moving(self, now_s: float) -> bool:
        """Tell whether it is under way."""
        return now_s < self._end_s

    def at(self, now_s: float) -> int:
        """Return where it is, in whole counts."""
        profile = self._profile
        return nearest(profile.end if now_s >= profile.end_s else profile.at(now_s))

    def rate(self, now_s: float) -> float:
        """Return how fast it goes, in counts a second."""
        return self._profile.speed_at(now_s)

    def hold(self, at: int) -> None:
        """Stand dead at a count."""
        self._profile, self._end_s = standing(at), -math.inf

    def go_to(
        self, goal: int, rate: float, slope: float, now_s: float, *, braking: float | None = None
    ) -> None:
        """Go to a count, from whatever is under way; an infinite slope is no ramp.

        `braking` is the slope of slowing down, where that is another.
        """
        position, speed = self._state(now_s)
        if math.isinf(slope):
            self._begin(dead(position, goal, rate, now_s), now_s)
        else:
            self._begin(to_goal(position, speed, goal, rate, slope, now_s, braking), now_s)

    def go_at(self, rate: float, slope: float, now_s: float) -> None:
        """Run until told otherwise; a rate of 0 ends it."""
        position, speed = self._state(now_s)
        self._begin(at_rate(position, speed, rate, slope, now_s), now_s)

    def passes_s(self, count: int, way: int, now_s: float) -> float:
        """Return when it comes to a count or beyond, seen in a direction; infinity for never.

        For what comes there and goes on: a search, or a motion towards a switch.
        """
        if (self.at(now_s) - count) * way >= 0:
            return now_s
        late_s = self._end_s
        if math.isinf(late_s):
            speed = abs(self._profile.pieces[-1].speed) if self._profile.pieces else 0.0
            if not speed:
                return math.inf
            late_s = self._profile.pieces[-1].start_s
            late_s += (abs(self.at(late_s) - count) + 1) / speed
        if late_s <= now_s or (self.at(late_s) - count) * way < 0:
            return math.inf
        return self._between(count, way, now_s, late_s)

    def _between(self, count: int, way: int, early_s: float, late_s: float) -> float:
        for _ in range(_HALVINGS):
            half_s = (early_s + late_s) / 2
            if (self.at(half_s) - count) * way >= 0:
                late_s = half_s
            else:
                early_s = half_s
        return late_s

    def _state(self, now_s: float) -> tuple[float, float]:
        """Return position and speed; one that stands does so on a whole count."""
        if not self.moving(now_s):
            return float(self.end), 0.0
        return self._profile.at(now_s), self._profile.speed_at(now_s)

    def _begin(self, profile: Profile, now_s: float) -> None:
        self._profile, self._end_s = profile, max(profile.end_s, now_s)


def dead(position: float, goal: float, rate: float, now_s: float) -> Profile:
    """Go to a goal at once at full speed, and stop there dead."""
    way = goal - position
    piece = Piece(now_s, position, math.copysign(rate, way), 0.0, abs(way) / rate)
    return Profile((piece,), goal)


def at_rate(position: float, speed: float, wanted: float, slope: float, now_s: float) -> Profile:
    """Run at a speed for ever, or stand; an infinite slope is no ramp."""
    if not math.isinf(slope):
        return to_speed(position, speed, wanted, slope, now_s)
    if not wanted:
        return standing(position)
    return Profile((Piece(now_s, position, wanted, 0.0, math.inf),), position)
