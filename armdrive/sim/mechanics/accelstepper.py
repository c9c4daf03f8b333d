"""Uncoordinated steppers, in the arithmetic of the AccelStepper library.

The library does not follow a trapezoid: each step sets the pause before the next one (D. Austin,
"Generate stepper-motor speed profiles in real time", Embedded Systems Programming, January 2005),
a pause counts from the step actually made, and a stop begins as soon as no more than v^2 / 2a
steps are left. A board that serves its motors in turn gives each motor a chance to step only at
fixed intervals, and a step waits for the next chance.

The orders correspond to the library's calls: `set_speed` to setSpeed, `set_top` to setMaxSpeed,
`aim` to moveTo, `ramp_down` to stop, `stand` to setCurrentPosition. A board moves its axes either
by runSpeed or by run (`obey`). `_paced` is computeNewSpeed, which run, moveTo and setMaxSpeed call.

Units: steps, seconds, steps per second.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import NamedTuple

_ROUNDING = 1e-9  # tolerance for floating-point rounding

# How often the arm's path is sampled, because it is not straight.
LOOK_S = 0.1
# How often a board without a grid serves its motors: no command acts at once.
LOOP_S = 0.0001
# Austin's correction of the first pause.
FIRST_PAUSE = 0.676


class _Moment(NamedTuple):
    """One motor after a step or a command; `pause_s` is infinity if no step follows.

    `ramp` counts the steps of the ramp so far, and is negative while the motor slows down. A tuple,
    because one is made for every step of a motion.
    """

    position: int
    goal: int
    last_s: float = -math.inf
    ramp: int = 0
    ramp_pause_s: float = math.inf
    pause_s: float = math.inf
    speed_hz: float = 0.0
    forward: bool = False


class _StepperAxis:
    """One motor; `phase_s` shifts its chances on the grid. A `grid_s` of 0 means no grid."""

    def __init__(
        self, count: int, acceleration: float, top_hz: float, grid_s: float, phase_s: float
    ) -> None:
        self._acceleration = acceleration
        self._first_pause_s = FIRST_PAUSE * math.sqrt(2.0 / acceleration)
        self.top_hz = top_hz
        self._grid_s = grid_s
        self._phase_s = phase_s
        self._by_speed = False
        self._since_s = -math.inf
        self._moment = _Moment(count, count)
        self._times: list[float] = []
        self._steps: list[_Moment] = []
        self._laid_s = -math.inf
        """The time up to which the steps of the present order have been computed."""

    # -- what can be seen ---------------------------------------------------------------------

    def at(self, now_s: float) -> _Moment:
        """Return the motor's state by now."""
        self._lay(now_s)
        made = bisect_right(self._times, now_s + _ROUNDING)
        return self._steps[made - 1] if made else self._moment

    @property
    def done_s(self) -> float:
        """When the motor makes its last step; infinity if it runs for ever or hangs."""
        if self._by_speed:
            return math.inf if self._moment.speed_hz else self._moment.last_s
        self._lay(math.inf)
        end = self._steps[-1] if self._steps else self._moment
        return end.last_s if end.position == end.goal else math.inf

    def moves(self, now_s: float) -> bool:
        """Return whether the board reports it as moving: by speed, only at a chance it has used."""
        moment = self.at(now_s)
        if self._by_speed:
            return now_s < moment.last_s + max(self._grid_s, LOOP_S)
        return bool(moment.speed_hz) or moment.position != moment.goal

    # -- orders, in the words of the library --------------------------------------------------

    def set_speed(self, speed_hz: float, now_s: float) -> None:
        """Run at a constant speed, no faster than the top speed, at least until the next step."""
        moment = self.at(now_s)
        if speed_hz == moment.speed_hz:
            return
        speed_hz = min(max(speed_hz, -self.top_hz), self.top_hz)
        self._order(
            moment._replace(
                pause_s=1.0 / abs(speed_hz) if speed_hz else math.inf,
                speed_hz=speed_hz,
                forward=speed_hz > 0.0 if speed_hz else moment.forward,
            ),
            now_s,
        )

    def set_top(self, top_hz: float, now_s: float) -> None:
        """Ramp up to this speed from now on, also in later motions."""
        if top_hz == self.top_hz:
            return
        moment = self.at(now_s)
        self.top_hz = top_hz
        if moment.ramp > 0:
            moment = self._paced(moment._replace(ramp=self._steps_to_stop(moment)))
        self._order(moment, now_s)

    def aim(self, goal: int, now_s: float) -> None:
        """Go to a goal; no effect if it is the goal already."""
        moment = self.at(now_s)
        if goal != moment.goal:
            self._order(self._paced(moment._replace(goal=goal)), now_s)

    def ramp_down(self, now_s: float) -> None:
        """Aim for the point where the motor can stop."""
        moment = self.at(now_s)
        if moment.speed_hz:
            steps = self._steps_to_stop(moment) + 1
            self.aim(moment.position + (steps if moment.speed_hz > 0.0 else -steps), now_s)

    def obey(self, now_s: float, *, by_speed: bool) -> None:
        """Run at the speed set, or to the goal."""
        if by_speed != self._by_speed:
            moment = self.at(now_s)
            self._by_speed = by_speed
            self._order(moment, now_s)

    def stand(self, at: int, now_s: float = -math.inf) -> None:
        """Stand at a count."""
        last_s = self.at(now_s).last_s if now_s > self._since_s else self._moment.last_s
        self._order(_Moment(at, at, last_s), max(now_s, self._since_s))

    # -- the library's arithmetic -------------------------------------------------------------

    def _order(self, moment: _Moment, now_s: float) -> None:
        self._moment, self._since_s = moment, now_s
        self._times, self._steps = [], []
        self._laid_s = -math.inf

    def _steps_to_stop(self, moment: _Moment) -> int:
        return int(moment.speed_hz**2 / (2.0 * self._acceleration))

    def _paced(self, moment: _Moment) -> _Moment:
        """Choose the pause before the next step."""
        left, to_stop = moment.goal - moment.position, self._steps_to_stop(moment)
        if not left and to_stop <= 1:
            return moment._replace(ramp=0, pause_s=math.inf, speed_hz=0.0)
        ramp, forward, pause_s = moment.ramp, moment.forward, moment.ramp_pause_s
        ahead = forward == (left > 0)
        if left and ramp > 0 and (to_stop >= abs(left) or not ahead):
            ramp = -to_stop
        elif left and ramp < 0 and to_stop < abs(left) and ahead:
            ramp = -ramp
        if not ramp:
            pause_s, forward = self._first_pause_s, left > 0
        elif math.isfinite(pause_s):
            pause_s -= 2.0 * pause_s / (4.0 * ramp + 1.0)
            pause_s = max(pause_s, 1.0 / self.top_hz if self.top_hz else math.inf)
        speed_hz = 1.0 / pause_s
        return _Moment(
            moment.position,
            moment.goal,
            moment.last_s,
            ramp=ramp + 1,
            ramp_pause_s=pause_s,
            pause_s=pause_s,
            speed_hz=speed_hz if forward else -speed_hz,
            forward=forward,
        )

    def _lay(self, until_s: float) -> None:
        """Compute the steps up to the requested time; they are kept until an order changes them."""
        if until_s <= self._laid_s:
            return
        self._laid_s = until_s
        moment = self._steps[-1] if self._steps else self._moment
        while (step_s := self._chance(moment)) <= until_s + _ROUNDING and math.isfinite(step_s):
            way = 1 if moment.forward else -1
            moment = moment._replace(position=moment.position + way, last_s=step_s)
            if not self._by_speed:
                moment = self._paced(moment)
            self._times.append(step_s)
            self._steps.append(moment)

    def _chance(self, moment: _Moment) -> float:
        """Return when the next step is made; infinity for never."""
        due_s = moment.last_s + moment.pause_s
        if math.isinf(moment.pause_s) or not self._grid_s:
            return math.inf if math.isinf(moment.pause_s) else max(due_s, self._since_s + LOOP_S)
        due_s = max(due_s, self._since_s + LOOP_S)
        number = math.ceil((due_s - self._phase_s) / self._grid_s - 1e-6)
        return number * self._grid_s + self._phase_s


class UncoordinatedRack:
    """Axes that move independently; `done_s` is when the last one has arrived."""

    def __init__(
        self,
        counts: Sequence[int],
        *,
        acceleration_hz_s: float,
        top_hz: float = math.inf,
        grid_s: float = 0.0,
        stagger_s: float = 0.0,
    ) -> None:
        self._axes = [
            _StepperAxis(count, acceleration_hz_s, top_hz, grid_s, number * stagger_s)
            for number, count in enumerate(counts)
        ]
        self._top_hz = top_hz
        self._under_way = False
        self._ordered_s = -math.inf
        self._done_s: float | None = None
        """The value of `done_s`, or None until it is computed for the latest order."""

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended since the last call of `settle`."""
        return self._under_way

    @property
    def done_s(self) -> float:
        """When the last axis stands; infinity if none moves or one runs without an end."""
        if not self._under_way:
            return math.inf
        if self._done_s is None:
            self._done_s = max([self._ordered_s, *(axis.done_s for axis in self._axes)])
        return self._done_s

    def mask(self, now_s: float) -> int:
        """Return a bit for each axis that still moves, the first axis in the lowest bit."""
        return sum(1 << n for n, axis in enumerate(self._axes) if axis.moves(now_s))

    def speeds(self, now_s: float) -> tuple[float, ...]:
        """Return the speed commanded for each axis, in steps per second."""
        return tuple(axis.at(now_s).speed_hz for axis in self._axes)

    def move_to(self, axis: int, goal: int, speed_hz: float, now_s: float) -> None:
        """Send an axis to a count, at most at its top speed.

        The given speed applies only until the first step. An axis already at its goal makes a step
        in that direction and one back, unless the speed is 0.
        """
        self._begin(now_s, by_speed=False)
        self._axes[axis].set_speed(speed_hz, now_s)
        self._axes[axis].aim(goal, now_s)

    def move_at(self, axis: int, goal: int, speed_hz: float, now_s: float) -> None:
        """Send an axis to a count at most at this speed, which stays its top speed."""
        self._begin(now_s, by_speed=False)
        self._axes[axis].set_speed(speed_hz, now_s)
        self._axes[axis].set_top(abs(speed_hz), now_s)
        self._axes[axis].aim(goal, now_s)

    def run(self, axis: int, speed_hz: float, now_s: float) -> None:
        """Make an axis run for ever, backwards if negative; 0 stops it dead."""
        self._begin(now_s, by_speed=True)
        self._axes[axis].set_speed(speed_hz, now_s)

    def ramp_down(self, now_s: float) -> None:
        """Slow down every axis that is going to a goal.

        Axes that run at a constant speed run on.
        """
        for axis in self._axes:
            axis.ramp_down(now_s)
        self._done_s = None

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        return tuple([axis.at(now_s).position for axis in self._axes])

    def bends(self, start_s: float, end_s: float) -> Iterator[float]:
        """Yield times at which to sample while anything moves."""
        last_s = min(end_s, self.done_s)
        for number in range(1, math.ceil((last_s - start_s) / LOOK_S)):
            yield start_s + number * LOOK_S
        if start_s < last_s < end_s:
            yield last_s

    def settle(self, now_s: float) -> None:
        """Fold finished motion into the counts."""
        if self._under_way and self.done_s <= now_s:
            self.stop(now_s)

    def stop(self, now_s: float) -> None:
        """Stop all motion dead."""
        for axis in self._axes:
            axis.stand(axis.at(now_s).position, now_s)
        self._under_way = False

    def count(self, deltas: Sequence[int]) -> None:
        """Add steps made outside any motion, while standing."""
        for axis, delta in zip(self._axes, deltas, strict=True):
            axis.stand(axis.at(-math.inf).position + delta)

    def zero(self) -> None:
        """Set the counts to zero. Nothing turns."""
        for axis in self._axes:
            axis.stand(0)
        self._under_way = False

    def restart(self) -> None:
        """Restore the top speeds that the firmware starts with."""
        for axis in self._axes:
            axis.top_hz = self._top_hz

    def _begin(self, now_s: float, *, by_speed: bool) -> None:
        for axis in self._axes:
            axis.obey(now_s, by_speed=by_speed)
        self._under_way, self._ordered_s, self._done_s = True, now_s, None
