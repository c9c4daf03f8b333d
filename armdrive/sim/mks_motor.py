"""The set-point of one closed-loop drive: where it has its shaft be at any moment, without ticking.

Encoder counts of the shaft's own, whatever zero was set; seconds; rpm and rpm a second.
"""

from __future__ import annotations

import math
from dataclasses import replace

from armdrive.sim.profile import Piece, Profile, nearest, standing, to_goal, to_speed
from firmware_protocol.mks import COUNTS_PER_TURN, MotorState, ramp_rpm_s

_HALVINGS = 60
_RPM = COUNTS_PER_TURN / 60.0
"""Counts a second of one rpm."""


class SetPoint:
    """It stands, or is under way on a ramped profile from whatever it did before."""

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

    def rpm(self, now_s: float) -> float:
        """Return how fast it goes; positive is counter-clockwise."""
        return self._profile.speed_at(now_s) / _RPM

    def hold(self, at: int) -> None:
        """Stand dead at a count."""
        self._profile, self._end_s = standing(at), -math.inf

    def move_to(self, goal: int, rpm: float, acc: int, now_s: float) -> None:
        """Go to a count, from whatever is under way."""
        position, speed = self._state(now_s)
        slope, rate = _slope(acc), rpm * _RPM
        if math.isinf(slope):
            self._begin(_dead(position, goal, rate, now_s), now_s)
        else:
            self._begin(to_goal(position, speed, goal, rate, slope, now_s), now_s)

    def run(self, rpm: float, acc: int, now_s: float) -> None:
        """Run until told otherwise; a speed of 0 ends it."""
        position, speed = self._state(now_s)
        self._begin(_to_speed(position, speed, rpm * _RPM, acc, now_s), now_s)

    def run_for(self, rpm: float, acc: int, time_s: float, now_s: float) -> None:
        """Run for a time, and then slow down."""
        self.run(rpm, acc, now_s)
        over_s = now_s + time_s
        pieces = [_cut(piece, over_s) for piece in self._profile.pieces if piece.start_s < over_s]
        last = pieces[-1]
        end = _to_speed(last.at(over_s), last.speed_at(over_s), 0.0, acc, over_s)
        self._begin(Profile((*pieces, *end.pieces), end.end), now_s)
        self._end_s = max(self._end_s, over_s)

    def there_and_back(self, counts: int, rpm: float, now_s: float) -> None:
        """Turn by so many counts and back again."""
        here = float(self.at(now_s))
        there = _dead(here, here + counts, rpm * _RPM, now_s)
        back = _dead(here + counts, here, rpm * _RPM, there.end_s)
        self._begin(Profile((*there.pieces, *back.pieces), here), now_s)

    def passes_s(self, count: int, way: int, now_s: float) -> float:
        """Return when it comes to a count or beyond, seen in a direction; infinity for never.

        For what goes one way only: a search, or a motion towards a switch.
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

    def state(self, now_s: float) -> MotorState:
        """Return what the drive says it does."""
        if not self.moving(now_s):
            return MotorState.STOPPED
        piece = next(each for each in self._profile.pieces if now_s < each.end_s)
        change = piece.acceleration * piece.speed_at(now_s)
        if not piece.acceleration:
            return MotorState.FULL_SPEED
        return MotorState.ACCELERATING if change >= 0.0 else MotorState.DECELERATING

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


def _slope(acc: int) -> float:
    """Return the counts a second squared of the drive's own measure; infinity without a ramp."""
    return ramp_rpm_s(acc) * _RPM


def _dead(position: float, goal: float, rate: float, now_s: float) -> Profile:
    """Go to a goal at once at full speed, and stop there dead."""
    way = goal - position
    piece = Piece(now_s, position, math.copysign(rate, way), 0.0, abs(way) / rate)
    return Profile((piece,), goal)


def _to_speed(position: float, speed: float, wanted: float, acc: int, now_s: float) -> Profile:
    slope = _slope(acc)
    if not math.isinf(slope):
        return to_speed(position, speed, wanted, slope, now_s)
    if not wanted:
        return standing(position)
    return Profile((Piece(now_s, position, wanted, 0.0, math.inf),), position)


def _cut(piece: Piece, over_s: float) -> Piece:
    return replace(piece, duration_s=min(piece.duration_s, over_s - piece.start_s))
