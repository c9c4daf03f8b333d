"""The set-point of one MKS drive, in the drive's own measures: rpm, and its steps of acceleration.

Encoder counts of the shaft's own, whatever zero was set; seconds.
"""

from __future__ import annotations

from dataclasses import replace

from armdrive.sim.profile import Piece, Profile
from armdrive.sim.shaft_point import ShaftPoint, at_rate, dead
from firmware_protocol.mks import COUNTS_PER_TURN, MotorState, ramp_rpm_s

_RPM = COUNTS_PER_TURN / 60.0
"""Counts a second of one rpm."""


class SetPoint(ShaftPoint):
    """It stands, or is under way on a ramped profile from whatever it did before."""

    def rpm(self, now_s: float) -> float:
        """Return how fast it goes; positive is counter-clockwise."""
        return self.rate(now_s) / _RPM

    def move_to(self, goal: int, rpm: float, acc: int, now_s: float) -> None:
        """Go to a count, from whatever is under way."""
        self.go_to(goal, rpm * _RPM, _slope(acc), now_s)

    def run(self, rpm: float, acc: int, now_s: float) -> None:
        """Run until told otherwise; a speed of 0 ends it."""
        self.go_at(rpm * _RPM, _slope(acc), now_s)

    def run_for(self, rpm: float, acc: int, time_s: float, now_s: float) -> None:
        """Run for a time, and then slow down."""
        self.run(rpm, acc, now_s)
        over_s = now_s + time_s
        pieces = [_cut(piece, over_s) for piece in self._profile.pieces if piece.start_s < over_s]
        last = pieces[-1]
        end = at_rate(last.at(over_s), last.speed_at(over_s), 0.0, _slope(acc), over_s)
        self._begin(Profile((*pieces, *end.pieces), end.end), now_s)
        self._end_s = max(self._end_s, over_s)

    def there_and_back(self, counts: int, rpm: float, now_s: float) -> None:
        """Turn by so many counts and back again."""
        here = float(self.at(now_s))
        there = dead(here, here + counts, rpm * _RPM, now_s)
        back = dead(here + counts, here, rpm * _RPM, there.end_s)
        self._begin(Profile((*there.pieces, *back.pieces), here), now_s)

    def state(self, now_s: float) -> MotorState:
        """Return what the drive says it does."""
        if not self.moving(now_s):
            return MotorState.STOPPED
        piece = next(each for each in self._profile.pieces if now_s < each.end_s)
        change = piece.acceleration * piece.speed_at(now_s)
        if not piece.acceleration:
            return MotorState.FULL_SPEED
        return MotorState.ACCELERATING if change >= 0.0 else MotorState.DECELERATING


def _slope(acc: int) -> float:
    """Return the counts a second squared of the drive's own measure; infinity without a ramp."""
    return ramp_rpm_s(acc) * _RPM


def _cut(piece: Piece, over_s: float) -> Piece:
    return replace(piece, duration_s=min(piece.duration_s, over_s - piece.start_s))
