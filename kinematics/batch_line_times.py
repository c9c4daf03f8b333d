"""The time of each of many points of a path, under speeds, accelerations and motor rates.

Angles in rad, times in s. The points are evenly spaced on the path's parameter, of which one unit
is one point. Squared speeds are limited at every point, and their change from point to point, so
the quickest profile is the least of lines of limited slope: a running sum of the slopes and a
running least, forwards and backwards.

The acceleration of a joint is its change by the path's own bend, times the squared speed, and by
speeding up. Both are taken at the worst joint each, as if they always added up; the bend may
have half of the limit at most, and speeding up what the fastest allowed speed leaves. So no speed
is passed, an acceleration by no more than a joint's rate changes from one step to the next (2 % of
it with a thousand points), and on strongly curved parts some is given away (timing.py gives away
less).
"""

from __future__ import annotations

import numpy as np

from kinematics.batch_trig import Array
from kinematics.timing_limits import MotionLimits

_TINY = 1e-300
"""Keeps a limit by a number from being a limit by nothing."""

_STEEPEST = 1e-6
"""Where nothing limits an acceleration: full speed within a millionth of the way to the next."""


class LineTimer:
    """Room for the points of a path, and the limits of its joints as rows of products."""

    def __init__(self, limits: MotionLimits, joints: int, points: int) -> None:
        speeds = np.diag([1.0 / speed for speed in limits.speeds[:joints]])
        motors = [np.array(row[:joints])[None] / limits.motor_hz for row in limits.motors]
        ramps = np.diag([1.0 / limit for limit in limits.accelerations[:joints]])
        bounded = ramps.any(axis=1)
        self._all_bounded, self.ramps = bool(bounded.all()), bool(bounded.any())
        self._limits = np.concatenate([speeds, *motors, ramps[bounded]])
        count, between = len(self._limits), points - 1
        fast = count - int(bounded.sum())
        self._changes = np.empty((joints, between))
        self._shares = np.empty((count, between))
        self._fast, self._hard = self._shares[:fast], self._shares[fast:]
        self._hard_before, self._hard_behind = self._hard[:, :-1], self._hard[:, 1:]
        self._bends = np.empty((count - fast, points - 2))
        self._bend = np.empty(points - 2)
        self._times, self._slopes, self._caps = np.empty((3, between))
        self._caps_before, self._caps_behind = self._caps[:-1], self._caps[1:]
        self._squares, self._bent, self._sums, self._double = np.zeros((4, points))
        self._inner, self._inner_bent = self._squares[1:-1], self._bent[1:-1]
        self._bent_before, self._bent_behind = self._bent[:-1], self._bent[1:]
        self._backwards, self._later_sums = self._squares[::-1], self._sums[1:]

    @np.errstate(all="ignore")
    def fill(self, joints: Array, speed: float, times_s: Array) -> None:
        """Fill the times of joints (5, N) of a path from rest to rest.

        The last of them is no number if the joints stand still from some point to the next.
        """
        times, shares = self._times, self._shares
        np.subtract(joints[:, 1:], joints[:, :-1], self._changes)
        np.matmul(self._limits, self._changes, out=shares)
        if self.ramps:
            np.subtract(self._hard_behind, self._hard_before, self._bends)
        np.abs(shares, shares)
        np.maximum.reduce(self._fast, axis=0, out=times)
        times_s[0] = 0.0
        if not self.ramps:
            times /= speed
            np.add.accumulate(times, out=times_s[1:])
            return
        self._limit(speed)
        speeds = self._pass()
        np.add(speeds[1:], speeds[:-1], times)
        np.divide(2.0, times, times)
        np.add.accumulate(times, out=times_s[1:])

    def _limit(self, speed: float) -> None:
        """Find the highest squared speed at every point, and its steepest change between them."""
        caps, slopes, bend, bends = self._caps, self._slopes, self._bend, self._bends
        inner, bent = self._inner, self._inner_bent
        np.multiply(self._times, self._times, caps)
        np.maximum.reduce(self._hard, axis=0, out=slopes)
        if not self._all_bounded:
            np.maximum(slopes, caps * _STEEPEST, out=slopes)
        np.divide(speed * speed, caps, caps)
        np.minimum(self._caps_behind, self._caps_before, out=inner)
        np.abs(bends, bends)
        np.maximum.reduce(bends, axis=0, out=bend)
        bend += _TINY
        np.divide(0.5, bend, bent)
        np.minimum(inner, bent, out=inner)
        np.multiply(inner, bend, bent)
        np.maximum(self._bent_behind, self._bent_before, out=caps)
        np.subtract(1.0, caps, caps)
        np.divide(caps, slopes, slopes)

    def _pass(self) -> Array:
        """Return the speed at every point: squares whose change nowhere passes its limit."""
        squares, sums, both = self._squares, self._sums, self._double
        np.add.accumulate(self._slopes, out=self._later_sums)
        np.multiply(sums, 4.0, both)
        sums *= 2.0
        squares -= sums
        np.minimum.accumulate(squares, out=squares)
        squares += both
        np.minimum.accumulate(self._backwards, out=self._backwards)
        squares -= sums
        squares[0] = squares[-1] = 0.0  # but for rounding, they are
        np.sqrt(squares, sums)
        return sums
