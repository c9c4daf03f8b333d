"""Descent towards a goal: Levenberg-Marquardt on floats, within joint limits or without.

Errors are dimensionless: mm are counted in the arm's length, and so are joints that slide.
Sources: Marquardt, 1963, by the normal equations; an active set holds joints at a limit while the
step points beyond it. numpy is not used: its calls take longer than the arithmetic of six joints.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import mul

from kinematics.chains.chain import Chain
from kinematics.chains.generated import functions_of, generated
from kinematics.chains.goals import (
    ALL_PARTS,
    HEADING_FREE,
    Goal,
    Part,
    turned_to,
)
from kinematics.chains.jacobians import length_of, units_of
from kinematics.frames.orientations import rotation_vector
from kinematics.frames.transforms import Transform
from kinematics.frames.vectors import dot
from kinematics.spaces import Jacobian

# By how much the first parts of a goal outweigh the others, increased step by step: the largest
# weight at once would make the valley of the error too narrow to follow.
STIFF = (10.0, 100.0, 1000.0)

# Postures nearer than this, in all, are one.
_SAME = 1e-3

# A step shorter than this moves nothing.
_STILL = 1e-13


@dataclass(frozen=True, slots=True)
class Pace:
    """How a descent changes its damping, and when it ends.

    The damping is a share of the largest diagonal entry of the system. It begins at `damping`
    and is multiplied by `easier`, down to `gentle`, after a step that gains, and by `harder` after
    one that does not; beyond `harsh` the descent ends. It also ends at a squared error below `met`,
    and after `patience` steps in a row that leave more than the share `hopeless` of it. A step
    without any gain counts as `doubts` such steps.
    """

    rounds: int
    met: float
    damping: float
    gentle: float
    harsh: float
    easier: float
    harder: float
    patience: int
    hopeless: float
    doubts: int


# From anywhere, to the last digit.
THOROUGH = Pace(80, 1e-28, 1e-3, 1e-13, 1e12, 0.1, 8.0, 4, 1.0 - 1e-9, 0)

# From a posture that nearly meets the goal.
FINISHING = replace(THOROUGH, rounds=8)

# One of many starts: given up as soon as three steps in a row gain less than a tenth each.
SEARCHING = Pace(40, 1e-22, 1e-2, 1e-12, 1e3, 0.3, 8.0, 3, 0.9, 1)

# A small step to within some 1e-7 mm, or an early end without success: a jog cannot wait.
QUICK = Pace(16, 1e-18, 1e-6, 1e-12, 1.0, 0.01, 30.0, 2, 0.999, 1)

Weights = dict[Part, float]
Rows = Sequence[Sequence[float]]


class Descent:
    """One goal of one chain, and the descents towards it.

    `first` are the parts of the goal to be met first where not all can be, the earlier the more.
    Without `limited` the joint limits are not looked at.
    """

    def __init__(
        self,
        chain: Chain,
        goal: Goal,
        first: Sequence[frozenset[Part]] = (),
        *,
        limited: bool = True,
    ) -> None:
        self._goal = goal
        self._first = [asked for parts in first if (asked := parts & goal.parts)]
        self._alike: Weights = dict.fromkeys(goal.parts, 1.0)
        self._made = generated(chain)
        self._length = length_of(chain)
        self._limits = chain.limits if limited else None
        self._turns_about_z = goal.parts == HEADING_FREE and not limited
        """Whether the goal's heading is one more joint, which is always where it serves best."""
        self._units = (*units_of(chain), 1.0) if self._turns_about_z else units_of(chain)
        self._slides = any(unit != 1.0 for unit in self._units)

    def meet(self, start: Sequence[float]) -> tuple[float, ...]:
        """Return where a descent on all asked parts, alike, ends."""
        return self._descend(start, self._alike, THOROUGH)[0]

    def met(self, start: Sequence[float], pace: Pace) -> tuple[float, ...] | None:
        """Return where a descent ends if it meets the goal, else None."""
        values, cost = self._descend(start, self._alike, pace)
        return values if cost < pace.met else None

    def settle(self, ends: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        """Go on from the best few ends of `meet`, giving way in the parts that come last."""
        picked = [ends[0]]
        for weights in (self._alike, self._weights(STIFF[0]), self._weights(STIFF[-1])):
            ranked = sorted(ends, key=lambda values: self._cost(values, weights))
            picked += [values for values in ranked if _apart(values, picked)][:2]
        found = []
        for values in picked:
            for stiff in STIFF:
                values, _ = self._descend(values, self._weights(stiff), THOROUGH)
            found.append(self._polished(values))
        return found

    def best(self, ends: Sequence[tuple[float, ...]]) -> tuple[float, ...]:
        """Return the end that misses least, what comes first counting first."""
        return min(ends, key=lambda values: self._cost(values, self._weights(STIFF[-1])))

    def _weights(self, stiff: float) -> Weights:
        """Return the weight of each part: the earlier it comes, the heavier."""
        levels = len(self._first)
        return self._alike | {
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
        pairs = enumerate(zip(values, self._limits or (), strict=True))
        held = [index for index, (value, limits) in pairs if value in limits]
        moved, cost = self._descend(values, weights, FINISHING, held)
        return moved if cost < FINISHING.met * 1e4 else values

    def _descend(
        self, start: Sequence[float], weights: Weights, pace: Pace, held: Sequence[int] = ()
    ) -> tuple[tuple[float, ...], float]:
        """Return where a descent from a start ends, and the squared error there."""
        values = self._clipped(start)
        error, rows = self._linear(values, weights)
        cost, damping, idle = _squared(error), pace.damping, 0
        if cost == math.inf:  # a goal so far away has no step that is a number
            return tuple(values), cost
        for _ in range(pace.rounds):
            if cost < pace.met or idle >= pace.patience:
                break
            step = self._step(values, rows, error, damping, held)
            moved = self._clipped([a + b for a, b in zip(values, step, strict=True)])
            if max([abs(a - b) for a, b in zip(values, moved, strict=True)]) < _STILL:
                break
            next_error, next_rows = self._linear(moved, weights)
            next_cost = _squared(next_error)
            if next_cost < cost:
                idle = idle + 1 if next_cost > pace.hopeless * cost else 0
                values, error, rows, cost = moved, next_error, next_rows, next_cost
                damping = max(damping * pace.easier, pace.gentle)
            else:
                idle += pace.doubts
                damping *= pace.harder
                if damping > pace.harsh:
                    break
        return tuple([one + 0.0 for one in values]), cost

    def _step(
        self,
        values: Sequence[float],
        rows: Rows,
        error: Sequence[float],
        damping: float,
        held: Sequence[int],
    ) -> Sequence[float]:
        """Return the damped least-squares step of the joints that are free to move."""
        if self._slides:
            rows = [list(map(mul, row, self._units)) for row in rows]
        if self._turns_about_z:
            *joints, _ = damped_step(6, len(values) + 1)(rows, error, damping)
            return list(map(mul, joints, self._units)) if self._slides else joints
        free = self._free(values, rows, error, held)
        if len(free) < len(values):
            rows = [[row[index] for index in free] for row in rows]
        if not free:
            return [0.0] * len(values)
        turns = damped_step(len(rows), len(free))(rows, error, damping)
        if len(free) == len(values) and not self._slides:
            return turns
        step = [0.0] * len(values)
        for index, turn in zip(free, turns, strict=True):
            step[index] = turn * self._units[index]
        return step

    def _free(
        self, values: Sequence[float], rows: Rows, error: Sequence[float], held: Sequence[int]
    ) -> Sequence[int]:
        """Return the joints that no limit holds back while they are pulled beyond it."""
        joints = range(len(values))
        if self._limits is None:
            return joints
        free = []
        for index, value, (low, high) in zip(joints, values, self._limits, strict=True):
            if index in held:
                continue
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
        frame, jacobian = self._made.fk_and_jacobian(values)
        if self._turns_about_z and weights is self._alike:
            error, whole = self._whole(frame, jacobian, turned_to(goal.frame, frame))
            upright = (0.0, 0.0, 0.0, 0.0, 0.0, -1.0)
            return error, [(*row, entry) for row, entry in zip(whole, upright, strict=True)]
        if weights is self._alike and goal.parts == ALL_PARTS:
            return self._whole(frame, jacobian, goal.frame)
        errors: list[float] = []
        rows: list[Sequence[float]] = []
        share = weights.get(Part.POSITION, 0.0) / self._length
        if share:
            for index in range(3):
                errors.append(share * (goal.frame[index][3] - frame[index][3]))
                rows.append([share * entry for entry in jacobian[index]])
        turning = list(zip(*jacobian[3:], strict=True))
        for part, axis, miss in goal.turn(frame)[1]:
            weight = weights.get(part, 0.0)
            if weight:
                errors.append(weight * miss)
                rows.append([weight * dot(column, axis) for column in turning])
        return errors, rows

    def _whole(
        self, frame: Transform, jacobian: Jacobian, target: Transform
    ) -> tuple[list[float], Rows]:
        """Return what `_linear` does where all parts count alike: no turn has to be split."""
        share = 1.0 / self._length
        (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = frame
        (u, v, w, to_x), (k, m, n, to_y), (p, q, r, to_z), _ = target
        turn = rotation_vector(
            (
                (u * a + v * b + w * c, u * d + v * e + w * f, u * g + v * h + w * i),
                (k * a + m * b + n * c, k * d + m * e + n * f, k * g + m * h + n * i),
                (p * a + q * b + r * c, p * d + q * e + r * f, p * g + q * h + r * i),
            )
        )
        error = [share * (to_x - x), share * (to_y - y), share * (to_z - z), *turn]
        rows = [[share * entry for entry in row] for row in jacobian[:3]]
        return error, [*rows, *jacobian[3:]]

    def _cost(self, values: Sequence[float], weights: Weights) -> float:
        """Return the sum of the squared weighted errors."""
        return _squared(self._linear(values, weights)[0])


def _apart(values: Sequence[float], others: Sequence[Sequence[float]]) -> bool:
    """Whether a posture is another one than these."""
    return all(math.dist(values, other) > _SAME for other in others)


def _squared(values: Sequence[float]) -> float:
    """Return the sum of squares."""
    return sum([value * value for value in values])


# One step: (JᵗJ + damping · largest diagonal entry) s = Jᵗ e, solved by Cholesky's decomposition
# (Marquardt, 1963).
#
# The solution is written out as code for each size of the system, every entry a local variable: it
# takes a tenth of the time of loops over lists, and descents do little else.

# Return the step for a Jacobian's rows, the errors, and the damping.
StepFinder = Callable[[Rows, Sequence[float], float], tuple[float, ...]]


@lru_cache(maxsize=16)
def damped_step(rows: int, columns: int) -> StepFinder:
    """Return the function for a Jacobian of this size."""
    found: StepFinder = functions_of(_source(rows, columns), {"sqrt": math.sqrt}, "steps")["step"]
    return found


def _source(rows: int, columns: int) -> str:
    """Return the source: a is the system, l its triangle, y and s the two substitutions."""
    joints = range(columns)
    listed = ", ".join(f"({', '.join(f'j{r}{c}' for c in joints)},)" for r in range(rows))
    lines = [f"{listed}, = rows", f"{', '.join(f'e{r}' for r in range(rows))}, = error"]
    for c in joints:
        lines += [
            f"a{c}{d} = " + "+".join(f"j{r}{c}*j{r}{d}" for r in range(rows)) for d in range(c + 1)
        ]
    diagonal = ", ".join(f"a{c}{c}" for c in joints)
    lines.append(f"damping *= max({diagonal}, 1e-300)")
    for c in joints:
        for d in range(c):
            less = "".join(f"-l{c}{k}*l{d}{k}" for k in range(d))
            lines.append(f"l{c}{d} = (a{c}{d}{less})*i{d}")
        less = "".join(f"-l{c}{k}*l{c}{k}" for k in range(c))
        lines.append(f"p{c} = a{c}{c}{less}+damping")
        lines.append(f"i{c} = 1.0/sqrt(p{c}) if p{c} > 0.0 else 0.0")
        pull = "+".join(f"j{r}{c}*e{r}" for r in range(rows))
        less = "".join(f"-l{c}{k}*y{k}" for k in range(c))
        lines.append(f"y{c} = ({pull}{less})*i{c}")
    for c in reversed(joints):
        less = "".join(f"-l{k}{c}*s{k}" for k in range(c + 1, columns))
        lines.append(f"s{c} = (y{c}{less})*i{c}")
    lines.append(f"return ({', '.join(f's{c}' for c in joints)},)")
    return "def step(rows, error, damping):\n" + "\n".join(f"    {line}" for line in lines)
