"""Steppers that turn each by itself: every axis its own trapezoid, finishing when it finishes.

Steps, seconds. With a step grid, an axis makes at most one step at each of its chances, and what
comes late delays all that follows: a motor that is asked for a step every 10 ms, and has a chance
every 8 ms, makes one every 16 ms.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence

from armdrive.sim.profile import Profile, nearest, standing, to_goal, to_speed

LOOK_S = 0.1
"""The way of the arm is looked at this often: it is no straight one."""
_ROUNDING = 1e-9


class _Axis:
    """One motor; `phase_s` shifts its chances on the grid, which is none where `grid_s` is 0."""

    def __init__(self, count: int, acceleration: float, grid_s: float, phase_s: float) -> None:
        self.goal = count
        self._acceleration = acceleration
        self._grid_s = grid_s
        self._phase_s = phase_s
        self._from = count
        self._profile: Profile = standing(count)
        self._steps: Iterator[tuple[float, int]] = iter(())
        self._times: list[float] = []
        self._counts: list[int] = []
        self._to_lay = False
        self._ideal_s = -math.inf
        self.done_s = -math.inf

    def count(self, now_s: float) -> int:
        """Return the steps made by now."""
        if not self._grid_s:
            return nearest(self._profile.at(now_s))
        if self._to_lay:
            self._lay(now_s)
        if not self._times:
            return self._from
        made = bisect_right(self._times, now_s + _ROUNDING)
        return self._counts[made - 1] if made else self._from

    def speed(self, now_s: float) -> float:
        """Return the speed that the axis is asked to have."""
        return self._profile.speed_at(now_s)

    def move_to(self, goal: int, rate_hz: float, now_s: float) -> None:
        """Go to a goal, from whatever is under way."""
        position, speed = self._state(now_s)
        self.goal = goal
        if rate_hz > 0.0:
            acceleration = self._acceleration
            self._begin(to_goal(position, speed, goal, rate_hz, acceleration, now_s), now_s)
        else:
            self.stand(self.count(now_s))

    def run(self, rate_hz: float, now_s: float, *, ramp: bool) -> None:
        """Run at a speed until told otherwise; 0 ends it."""
        position, speed = self._state(now_s)
        slope = self._acceleration
        first = speed if ramp else rate_hz
        self._begin(to_speed(position, first, rate_hz, slope, now_s), now_s)
        if not math.isinf(self.done_s):
            self.goal = nearest(self._profile.end)

    def stand(self, at: int) -> None:
        """Stand dead at a count."""
        self.goal = self._from = at
        self._profile = standing(at)
        self._steps = iter(())
        self._times, self._counts = [], []
        self._to_lay = False
        self.done_s = -math.inf

    def _state(self, now_s: float) -> tuple[float, float]:
        """Return where the axis is and how fast, on its grid if it has one."""
        if not self._grid_s:
            return self._profile.at(now_s), self._profile.speed_at(now_s)
        most = 1.0 / self._grid_s
        speed = self._profile.speed_at(now_s) if now_s < self.done_s else 0.0
        return float(self.count(now_s)), min(max(speed, -most), most)

    def _begin(self, profile: Profile, now_s: float) -> None:
        self._from = self.count(now_s)
        made = bisect_right(self._times, now_s + _ROUNDING)
        taken = self._times[made - 1 : made]
        self._profile = profile
        self.done_s = max(profile.end_s, now_s)
        if not self._grid_s:
            return
        self._steps, self._ideal_s, self._to_lay = profile.crossings(), now_s, True
        self._times, self._counts = taken, [self._from] * len(taken)
        if not math.isinf(self.done_s):
            self._lay(math.inf)
            self.done_s = max([now_s, *self._times[-1:]])

    def _lay(self, until_s: float) -> None:
        """Give each step its chance on the grid, as far as anybody has looked."""
        last = self._times[-1] if self._times else -math.inf
        while last <= until_s:
            step = next(self._steps, None)
            if step is None:
                self._to_lay = False
                return
            ideal_s, way = step
            due_s = ideal_s if math.isinf(last) else max(last + ideal_s - self._ideal_s, ideal_s)
            self._ideal_s = ideal_s
            last = self._chance(due_s, last)
            self._times.append(last)
            self._counts.append((self._counts[-1] if self._counts else self._from) + way)

    def _chance(self, due_s: float, last_s: float) -> float:
        """Return the first chance of this axis from a moment on, after the last one it took."""
        number = math.ceil((due_s - self._phase_s) / self._grid_s - 1e-6)
        chance = number * self._grid_s + self._phase_s
        return chance if chance > last_s + self._grid_s / 2 else last_s + self._grid_s


class UncoordinatedRack:
    """Axes that each go their own way; `done_s` is when the last one has arrived."""

    def __init__(
        self,
        counts: Sequence[int],
        *,
        acceleration_hz_s: float,
        grid_s: float = 0.0,
        stagger_s: float = 0.0,
    ) -> None:
        self._axes = [
            _Axis(count, acceleration_hz_s, grid_s, number * stagger_s)
            for number, count in enumerate(counts)
        ]
        self._under_way = False

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and nobody has called `settle` since."""
        return self._under_way

    @property
    def done_s(self) -> float:
        """When the last axis stands; infinity while none moves, or one runs without an end."""
        return max([axis.done_s for axis in self._axes]) if self._under_way else math.inf

    @property
    def goals(self) -> tuple[int, ...]:
        """Where each axis is going, or stands."""
        return tuple(axis.goal for axis in self._axes)

    def mask(self, now_s: float) -> int:
        """Return a bit for each axis that still moves, the first axis lowest."""
        return sum(1 << n for n, axis in enumerate(self._axes) if axis.done_s > now_s)

    def speeds(self, now_s: float) -> tuple[float, ...]:
        """Return the speed that each axis is asked to have, in steps a second."""
        return tuple(axis.speed(now_s) for axis in self._axes)

    def move_to(self, axis: int, goal: int, rate_hz: float, now_s: float) -> None:
        """Send an axis to a count at most this fast; from a motion it turns without a jerk."""
        self._axes[axis].move_to(goal, rate_hz, now_s)
        self._under_way = True

    def run(self, axis: int, rate_hz: float, now_s: float, *, ramp: bool = True) -> None:
        """Have an axis run for ever, backwards where negative; 0 ends it, ramped or dead."""
        self._axes[axis].run(rate_hz, now_s, ramp=ramp)
        self._under_way = True

    def ramp_down(self, now_s: float) -> None:
        """Slow every axis down to a stand-still."""
        for axis in self._axes:
            if axis.done_s > now_s:
                axis.run(0.0, now_s, ramp=True)

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        return tuple([axis.count(now_s) for axis in self._axes])

    def bends(self, start_s: float, end_s: float) -> Iterator[float]:
        """Yield moments at which to look, while anything moves."""
        last_s = min(end_s, max([axis.done_s for axis in self._axes]))
        for number in range(1, math.ceil((last_s - start_s) / LOOK_S)):
            yield start_s + number * LOOK_S
        if start_s < last_s < end_s:
            yield last_s

    def settle(self, now_s: float) -> None:
        """Take in a motion that has ended."""
        if self._under_way and self.done_s <= now_s:
            self.stop(now_s)

    def stop(self, now_s: float) -> None:
        """End all motion dead where it is now."""
        for axis in self._axes:
            axis.stand(axis.count(now_s))
        self._under_way = False

    def count(self, deltas: Sequence[int]) -> None:
        """Count steps that were made apart from any motion, while standing."""
        for axis, delta in zip(self._axes, deltas, strict=True):
            axis.stand(axis.goal + delta)

    def zero(self) -> None:
        """Begin to count anew; nothing turns."""
        for axis in self._axes:
            axis.stand(0)
        self._under_way = False
