"""Descent towards a goal within joint limits: Levenberg-Marquardt with an active set.

Errors are dimensionless: mm are counted in the arm's length. Sources: Marquardt, 1963; the active
set holds joints at a limit while the step points beyond it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.goals import Goal, Part
from kinematics.chains.jacobians import length_of, units_of
from kinematics.frames.transforms import Transform
from kinematics.frames.vectors import dot
from kinematics.spaces import Jacobian

Floats = NDArray[np.float64]

ROUNDS = 80
STIFF = (10.0, 100.0, 1000.0)
"""By how much the errors that are to be met first outweigh the others, step by step: at once it
would make a valley too narrow to walk along."""

_DONE = 1e-28
"""Cost (a squared error) at which nothing is left to gain."""

_GAIN = 1e-9
_PATIENCE = 4
"""This many steps that gain less than that share of the cost end a descent."""

_SAME = 1e-3
"""Postures nearer than this, in all, are one."""

_STILL = 1e-13
"""A step shorter than this moves nothing."""


class Descent:
    """One goal of one chain, and the descents towards it."""

    def __init__(self, chain: Chain, goal: Goal, first: Sequence[frozenset[Part]]) -> None:
        self._goal = goal
        self._first = [asked for parts in first if (asked := parts & goal.parts)]
        self._made = generated(chain)
        self._length = length_of(chain)
        self._units = units_of(chain)
        self._limits = [
            (low / unit, high / unit)
            for (low, high), unit in zip(chain.limits, self._units, strict=True)
        ]

    def meet(self, start: Sequence[float]) -> tuple[float, ...]:
        """Return where a descent on all asked parts, alike, ends."""
        return self._descend(start, dict.fromkeys(self._goal.parts, 1.0))

    def settle(self, ends: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        """Go on from the best few ends of `meet`, giving way in the parts that come last."""
        alike: dict[Part, float] = dict.fromkeys(self._goal.parts, 1.0)
        picked = [ends[0]]
        for weights in (alike, self._weights(STIFF[0]), self._weights(STIFF[-1])):
            ranked = sorted(ends, key=lambda values: self._cost(values, weights))
            picked += [values for values in ranked if _apart(values, picked)][:2]
        found = []
        for values in picked:
            for stiff in STIFF:
                values = self._descend(values, self._weights(stiff))
            found.append(self._polished(values))
        return found

    def best(self, ends: Sequence[tuple[float, ...]]) -> tuple[float, ...]:
        """Return the end that misses least, what comes first counting first."""
        return min(ends, key=lambda values: self._cost(values, self._weights(STIFF[-1])))

    def _weights(self, stiff: float) -> dict[Part, float]:
        """Return the weight of each part: the earlier it comes, the heavier."""
        levels = len(self._first)
        weights = dict.fromkeys(self._goal.parts, 1.0)
        return weights | {
            part: stiff ** (levels - index)
            for index, parts in enumerate(self._first)
            for part in parts
        }

    def _polished(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """Meet the first parts exactly, by small moves, where they can be met at all.

        Joints at a limit stay there: that is where the other parts have pushed them.
        """
        if not self._first:
            return values
        weights = dict.fromkeys(self._first[0], 1.0)
        held = [
            index
            for index, (value, unit, limits) in enumerate(
                zip(values, self._units, self._limits, strict=True)
            )
            if value / unit in limits
        ]
        moved = self._descend(values, weights, 8, held)
        near = self._cost(moved, weights) < _DONE * 1e4
        return moved if near else values

    def _descend(
        self,
        start: Sequence[float],
        weights: dict[Part, float],
        rounds: int = ROUNDS,
        held: Sequence[int] = (),
    ) -> tuple[float, ...]:
        values = self._clipped(np.array(start) / self._units)
        error, slopes = self._linear(values, weights)
        cost, damping, idle = float(error @ error), 1e-3, 0
        for _ in range(rounds):
            free = [one for one in self._free(values, slopes.T @ error) if one not in held]
            if cost < _DONE or idle >= _PATIENCE or not free:
                break
            step = np.zeros(len(values))
            step[free] = _step(slopes[:, free], error, damping)
            moved = self._clipped(values + step)
            if float(np.abs(moved - values).max()) < _STILL:
                break
            next_error, next_slopes = self._linear(moved, weights)
            next_cost = float(next_error @ next_error)
            idle = idle + 1 if cost * (1.0 - _GAIN) < next_cost <= cost else 0
            if next_cost < cost:
                values, error, slopes, cost = moved, next_error, next_slopes, next_cost
                damping = max(damping * 0.1, 1e-15)
            else:
                damping *= 8.0
                if damping > 1e12:
                    break
        return tuple(float(one) + 0.0 for one in values * self._units)

    def _free(self, values: Floats, pull: Floats) -> list[int]:
        """Return the joints that are not held at a limit by a pull beyond it."""
        return [
            index
            for index, (low, high) in enumerate(self._limits)
            if not (values[index] <= low and pull[index] < 0.0)
            and not (values[index] >= high and pull[index] > 0.0)
        ]

    def _clipped(self, values: Floats) -> Floats:
        lows, highs = zip(*self._limits, strict=True)
        return np.clip(values, lows, highs)

    def _linear(self, values: Floats, weights: dict[Part, float]) -> tuple[Floats, Floats]:
        """Return the weighted errors, and how the joints reduce them."""
        frame, jacobian = self._made.fk_and_jacobian((values * self._units).tolist())
        errors, rows = self._errors(frame, jacobian, weights)
        return np.array(errors), np.array(rows) * self._units

    def _errors(
        self, frame: Transform, jacobian: Jacobian, weights: dict[Part, float]
    ) -> tuple[list[float], list[list[float]]]:
        goal = self._goal
        errors: list[float] = []
        rows: list[list[float]] = []
        share = weights.get(Part.POSITION, 0.0) / self._length
        if share:
            for index in range(3):
                errors.append(share * (goal.frame[index][3] - frame[index][3]))
                rows.append([share * entry for entry in jacobian[index]])
        for part, axis, miss in goal.turn(frame)[1]:
            weight = weights.get(part, 0.0)
            if weight:
                errors.append(weight * miss)
                rows.append(
                    [weight * dot((a, b, c), axis) for a, b, c in zip(*jacobian[3:], strict=True)]
                )
        return errors, rows

    def _cost(self, values: Sequence[float], weights: dict[Part, float]) -> float:
        """Return the sum of the squared weighted errors."""
        frame, jacobian = self._made.fk_and_jacobian(values)
        errors, _ = self._errors(frame, jacobian, weights)
        return math.fsum(error * error for error in errors)


def _apart(values: Sequence[float], others: Sequence[Sequence[float]]) -> bool:
    """Whether a posture is another one than these."""
    return all(math.dist(values, other) > _SAME for other in others)


def _step(slopes: Floats, error: Floats, damping: float) -> Floats:
    """Return the damped least-squares step, from the stacked system and not its square."""
    count = slopes.shape[1]
    stacked = np.vstack([slopes, math.sqrt(damping) * np.eye(count)])
    padded = np.concatenate([error, np.zeros(count)])
    step: Floats = np.linalg.lstsq(stacked, padded, rcond=None)[0]
    return step
