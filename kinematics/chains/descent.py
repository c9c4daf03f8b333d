"""Descent towards a goal: Levenberg-Marquardt on floats, within joint limits or without.

Errors are dimensionless: mm are counted in the arm's length, and so are joints that slide.
Sources: Marquardt, 1963, by the normal equations; an active set holds joints at a limit while the
step points beyond it. numpy is not used: its calls take longer than the arithmetic of six joints.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import mul
from typing import NamedTuple

from kinematics.chains.chain import Chain
from kinematics.chains.evaluation import evaluator
from kinematics.chains.goals import HAND_PARTS, HEADING_FREE, Goal, Part, turned_to
from kinematics.chains.jacobians import length_of, units_of
from kinematics.frames.orientations import rotation_vector
from kinematics.frames.rotations import multiply, transpose
from kinematics.frames.transforms import rotation_of
from kinematics.frames.vectors import dot

# A step shorter than this moves nothing.
_STILL = 1e-13

# The damping is a share of the largest diagonal entry of the system: where it ends, and by how much
# a step that gains eases it and one that does not increases it.
_LEAST_DAMPING, _MOST_DAMPING, _EASIER, _HARDER = 1e-13, 1e6, 0.1, 8.0


class Pace(NamedTuple):
    """How a descent begins, and when it ends.

    It ends at a squared error below `met`, or after `patience` steps in a row that leave more than
    the share `hopeless` of it.
    """

    rounds: int
    met: float
    damping: float
    patience: int
    hopeless: float


# From anywhere, to the last digit.
THOROUGH = Pace(80, 1e-28, 1e-3, 12, 1.0 - 1e-9)

# One of many starts: given up as soon as three steps in a row gain less than a tenth each.
SEARCHING = Pace(40, 1e-22, 1e-2, 3, 0.9)

# A small step to within some 1e-7 mm, or an early end without success: a jog cannot wait.
QUICK = Pace(16, 1e-18, 1e-6, 2, 0.999)

Rows = Sequence[Sequence[float]]


class Weights(NamedTuple):
    """How much mm, counted in the arm's length, and rad count."""

    position: float = 1.0
    hand: float = 1.0


ALIKE = Weights()


class End(NamedTuple):
    """Where a descent ends, and the squared weighted error there."""

    values: tuple[float, ...]
    cost: float


class Descent:
    """One goal of one chain, and the descents towards it; unlimited ones ignore joint limits."""

    def __init__(self, chain: Chain, goal: Goal, *, limited: bool = True) -> None:
        self._goal = goal
        self._evaluator = evaluator(chain)
        self._length = length_of(chain)
        self._limits = chain.limits if limited else None
        # The heading that a goal leaves free is one more joint, always where it serves best.
        self._heading_joint = goal.parts == HEADING_FREE
        self._units = (*units_of(chain), 1.0) if self._heading_joint else units_of(chain)

    def met(self, start: Sequence[float], pace: Pace) -> tuple[float, ...] | None:
        """Return where a descent ends if it meets the goal, else None."""
        values, cost = self.run(start, pace)
        return values if cost < pace.met else None

    def run(self, start: Sequence[float], pace: Pace, weights: Weights = ALIKE) -> End:
        """Return where a descent from a start ends."""
        values = self._clipped(start)
        error, rows = self._linear(values, weights)
        cost, damping, idle = _squared(error), pace.damping, 0
        for _ in range(pace.rounds):
            # a goal so far away that its square is infinite has no step that is a number
            if cost < pace.met or idle >= pace.patience or cost == math.inf:
                break
            step = self._step(values, rows, error, damping)
            moved = self._clipped([a + b for a, b in zip(values, step, strict=True)])
            if max([abs(a - b) for a, b in zip(values, moved, strict=True)]) < _STILL:
                break
            next_error, next_rows = self._linear(moved, weights)
            next_cost = _squared(next_error)
            idle = idle + 1 if next_cost > pace.hopeless * cost else 0
            if next_cost < cost:
                values, error, rows, cost = moved, next_error, next_rows, next_cost
                damping = max(damping * _EASIER, _LEAST_DAMPING)
            else:
                damping *= _HARDER
                if damping > _MOST_DAMPING:
                    break
        return End(tuple([one + 0.0 for one in values]), cost)

    def cost(self, values: Sequence[float], weights: Weights) -> float:
        """Return the squared weighted error of a posture."""
        return _squared(self._linear(values, weights)[0])

    def _step(
        self, values: Sequence[float], rows: Rows, error: Sequence[float], damping: float
    ) -> Sequence[float]:
        """Return the damped least-squares step of the joints that are free to move."""
        rows = [list(map(mul, row, self._units)) for row in rows]
        free = self._free(values, rows, error)
        step = [0.0] * len(self._units)
        if free:
            rows = [[row[index] for index in free] for row in rows]
            turns = damped_step(rows, error, damping)
            for index, turn in zip(free, turns, strict=True):
                step[index] = turn * self._units[index]
        return step[: len(values)]

    def _free(self, values: Sequence[float], rows: Rows, error: Sequence[float]) -> Sequence[int]:
        """Return the joints that no limit holds back while they are pulled beyond it."""
        if self._limits is None:
            return range(len(self._units))
        free = [len(values)] if self._heading_joint else []
        for index, (value, (low, high)) in enumerate(zip(values, self._limits, strict=True)):
            if value <= low or value >= high:
                pull = sum([row[index] * miss for row, miss in zip(rows, error, strict=True)])
                if (value <= low and pull < 0.0) or (value >= high and pull > 0.0):
                    continue
            free.append(index)
        return free

    def _clipped(self, values: Sequence[float]) -> Sequence[float]:
        if self._limits is None:
            return values
        return [
            min(max(value, low), high)
            for value, (low, high) in zip(values, self._limits, strict=True)
        ]

    def _linear(self, values: Sequence[float], weights: Weights) -> tuple[list[float], Rows]:
        """Return the weighted errors, and how the joints reduce them."""
        goal = self._goal
        frame, jacobian = self._evaluator.fk_and_jacobian(values)
        errors: list[float] = []
        rows: list[list[float]] = []
        if Part.POSITION in goal.parts:
            share = weights.position / self._length
            errors += [share * (goal.frame[i][3] - frame[i][3]) for i in range(3)]
            rows += [[share * entry for entry in row] for row in jacobian[:3]]
        if goal.parts >= HAND_PARTS or self._heading_joint:  # a whole turn need not be split
            target = turned_to(goal.frame, frame) if self._heading_joint else goal.frame
            whole = multiply(rotation_of(target), transpose(rotation_of(frame)))
            errors += [weights.hand * miss for miss in rotation_vector(whole)]
            rows += [[weights.hand * entry for entry in row] for row in jacobian[3:]]
            if self._heading_joint:
                rows = [[*row, 0.0] for row in rows]
                rows[-1][-1] = -weights.hand
            return errors, rows
        turning = list(zip(*jacobian[3:], strict=True))
        for _, axis, miss in goal.turn(frame)[1]:
            errors.append(weights.hand * miss)
            rows.append([weights.hand * dot(column, axis) for column in turning])
        return errors, rows


def _squared(values: Sequence[float]) -> float:
    """Return the sum of squares."""
    return sum([value * value for value in values])


def damped_step(rows: Rows, error: Sequence[float], damping: float) -> list[float]:
    """Return the solution s of (JᵗJ + damping · largest diagonal entry) s = Jᵗ e (Marquardt, 1963).

    By Cholesky's decomposition: each column of the system becomes a row of its triangle.
    """
    columns = list(zip(*rows, strict=True))
    damping *= max([_squared(column) for column in columns] + [1e-300])
    triangle: list[list[float]] = []
    shares: list[float] = []  # of 1, by the diagonal of the triangle
    step: list[float] = []
    for column in columns:
        line: list[float] = []
        for before, known, share in zip(columns, triangle, shares, strict=False):
            entry = sum(map(mul, column, before)) - sum(map(mul, line, known))
            line.append(entry * share)
        square = _squared(column) + damping - _squared(line)
        shares.append(1.0 / math.sqrt(square) if square > 0.0 else 0.0)
        step.append((sum(map(mul, column, error)) - sum(map(mul, line, step))) * shares[-1])
        triangle.append(line)
    for index in reversed(range(len(step))):
        step[index] *= shares[index]
        for earlier, entry in enumerate(triangle[index]):
            step[earlier] -= entry * step[index]
    return step
