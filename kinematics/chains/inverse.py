"""Inverse kinematics of any chain by numbers, with limits, restarts and an honest account.

Levenberg-Marquardt steps (Marquardt, 1963) on the position error, counted in lengths of the arm,
and the rotation vector of the orientation error (Craig, chapter 5; Wampler, 1986), joints held at
a limit while the step points beyond it. What is answered is always measured again by the product
of the A matrices. Where not all can be met, the parts named first are met first. Lengths in mm,
angles in rad. numpy is imported when the first goal is solved.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING

from kinematics.chains.chain import LIMIT_TOLERANCE_MM, Chain, JointViolation
from kinematics.chains.generated import Jacobian, generated
from kinematics.chains.goals import Goal, Part, frame_goal, pose_goal
from kinematics.chains.links import JointKind
from kinematics.chains.singularities import condition, length_of
from kinematics.frames.transforms import Transform, position_of
from kinematics.frames.vectors import distance, dot, norm
from kinematics.limits import turn_into
from kinematics.spaces import Pose, RollFrame

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


# Descent towards a goal within joint limits: Levenberg-Marquardt with an active set.
#
# Errors are dimensionless: mm are counted in the arm's length.

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
        self._units = [self._length if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds]
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
        import numpy as np

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
        import numpy as np

        lows, highs = zip(*self._limits, strict=True)
        return np.clip(values, lows, highs)

    def _linear(self, values: Floats, weights: dict[Part, float]) -> tuple[Floats, Floats]:
        """Return the weighted errors, and how the joints reduce them."""
        import numpy as np

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
    import numpy as np

    count = slopes.shape[1]
    stacked = np.vstack([slopes, math.sqrt(damping) * np.eye(count)])
    padded = np.concatenate([error, np.zeros(count)])
    step: Floats = np.linalg.lstsq(stacked, padded, rcond=None)[0]
    return step


# The account of a numerical solution: what was met, what was missed, by how much, and why.
#
# Measured by the product of the A matrices, not by what the solver believes.

FAR_FROM_SINGULAR = 1e-4
"""Smallest singular value, dimensionless, above which an arm is not at the edge of its reach."""


class Reason(Enum):
    """Why a goal was not met; the value says how sure that is."""

    NONE = "the goal is met"
    BEYOND_REACH = "the goal is further away than all links together are long, for certain"
    JOINT_LIMIT = "without the joint limits the goal is met; no posture within them was found"
    TOO_FEW_AXES = (
        "the position is met, but the arm has fewer axes than the goal asks, so that the hand "
        "cannot be turned as asked there"
    )
    NOT_FOUND = "no posture was found that meets the goal, with or without the joint limits"


@dataclass(frozen=True, slots=True)
class Solution:
    """The best posture found, within the limits, and how far it meets the goal.

    `met` and `missed` are the asked parts within and beyond the tolerances. `frame` is the
    tool's frame in this posture: the nearest pose that was found. `residual_mm` is the distance
    of its position from the asked one and `residual_rad` the angle by which it must still be
    turned, zero where position or orientation was not asked; `misses_rad` splits the angle into
    the asked ones of heading, pitch and roll. `violations` are the limits that a posture which
    meets the goal would break, and `at_limit` the joints that this posture holds at a limit.
    `starts` postures were tried.
    """

    joints: tuple[float, ...]
    frame: Transform
    met: frozenset[Part]
    missed: frozenset[Part]
    residual_mm: float
    residual_rad: float
    misses_rad: tuple[tuple[Part, float], ...]
    reason: Reason
    violations: tuple[JointViolation, ...]
    at_limit: tuple[str, ...]
    starts: int
    sentence: str

    @property
    def ok(self) -> bool:
        """Whether everything asked is met."""
        return not self.missed


def account(
    chain: Chain,
    goal: Goal,
    values: Sequence[float],
    tolerance_mm: float,
    tolerance_rad: float,
    starts: int = 0,
    unlimited: Sequence[float] | None = None,
) -> Solution:
    """Return the account of a posture; `unlimited` is one that meets the goal without limits."""
    joints = tuple(values)
    frame = chain.fk(joints)
    asked_position = Part.POSITION in goal.parts
    residual_mm = distance(position_of(frame), position_of(goal.frame)) if asked_position else 0.0
    turn, split = goal.turn(frame)
    misses = tuple((part, abs(miss)) for part, _, miss in split)
    residual_rad = norm(turn)
    missed = {part for part, miss in misses if miss > tolerance_rad}
    if residual_mm > tolerance_mm:
        missed.add(Part.POSITION)
    if residual_rad > math.sqrt(3.0) * tolerance_rad and not missed - {Part.POSITION}:
        missed |= {part for part, _ in misses}  # a turn that the split does not show
    broken = chain.violations(joints if unlimited is None else unlimited)
    reason = _reason(chain, goal, joints, missed, broken, unlimited is not None)
    return Solution(
        joints,
        frame,
        goal.parts - missed,
        frozenset(missed),
        residual_mm,
        residual_rad,
        misses,
        reason,
        broken if missed else (),
        _at_limit(chain, joints),
        starts,
        _sentence(reason, missed, residual_mm, misses, broken, starts),
    )


def _reason(
    chain: Chain,
    goal: Goal,
    joints: Sequence[float],
    missed: set[Part],
    broken: Sequence[JointViolation],
    met_without_limits: bool,
) -> Reason:
    if not missed:
        return Reason.NONE
    if beyond_reach(chain, goal):
        return Reason.BEYOND_REACH
    if met_without_limits and broken:
        return Reason.JOINT_LIMIT
    asked = len(goal.parts) + (2 if Part.POSITION in goal.parts else 0)
    if Part.POSITION not in missed and len(chain) < asked and _all_axes_used(chain, joints):
        return Reason.TOO_FEW_AXES
    return Reason.NOT_FOUND


def beyond_reach(chain: Chain, goal: Goal) -> bool:
    """Whether a goal is too far away for certain."""
    centre, radius = chain.reach_sphere
    return Part.POSITION in goal.parts and (
        distance(centre, position_of(goal.frame)) > radius * (1.0 + 1e-9)
    )


def _all_axes_used(chain: Chain, joints: Sequence[float]) -> bool:
    """Whether every joint can move the hand here: it is another axis that lacks, not room."""
    return not _at_limit(chain, joints) and condition(chain, joints).smallest > FAR_FROM_SINGULAR


def _at_limit(chain: Chain, joints: Sequence[float]) -> tuple[str, ...]:
    return tuple(
        name
        for name, value, bounds in zip(chain.joint_names, joints, chain.limits, strict=True)
        if min(abs(value - bound) for bound in bounds) <= LIMIT_TOLERANCE_MM
    )


def _sentence(
    reason: Reason,
    missed: set[Part],
    residual_mm: float,
    misses: Sequence[tuple[Part, float]],
    broken: Sequence[JointViolation],
    starts: int,
) -> str:
    if not missed:
        return reason.value
    said = [f"position by {residual_mm:.3g} mm"] if Part.POSITION in missed else []
    said += [
        f"{part.value} by {math.degrees(miss):.3g}°" for part, miss in misses if part in missed
    ]
    text = f"missed: {', '.join(said)}; {reason.value}"
    if reason is Reason.JOINT_LIMIT:
        text += ": " + "; ".join(_limit(one) for one in broken)
    if reason is Reason.NOT_FOUND:
        text += f" ({starts} starts, which is no proof that there is none)"
    return text


def _limit(one: JointViolation) -> str:
    joint = one.joint.replace("_", " ")
    if one.unit == JointKind.REVOLUTE.unit:
        value, bound, unit = math.degrees(one.value), math.degrees(one.bound), "°"
    else:
        value, bound, unit = one.value, one.bound, " mm"
    return (
        f"the {joint} would have to be at {value:.1f}{unit}, {abs(value - bound):.1f}{unit} beyond "
        f"its limit of {bound:.1f}{unit}"
    )


First = Sequence[frozenset[Part]]
"""Parts that are to be met before others where not all can be: the earlier the set, the more."""

POSITION_FIRST: First = (frozenset({Part.POSITION}),)
"""Keep the position, and turn the hand as nearly as it goes."""

PITCH_FIRST: First = (frozenset({Part.PITCH, Part.ROLL}), frozenset({Part.POSITION}))
"""Keep pitch and roll, and come as near to the position as that lets the arm."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How hard to look, and how near is met.

    `starts` postures are tried: the seed, the middle of the ranges, then random ones drawn from
    `random_seed`, so that the same question always has the same answer. A part is met within
    `tolerance_mm` or `tolerance_rad`.
    """

    starts: int = 24
    random_seed: int = 1
    tolerance_mm: float = 1e-4
    tolerance_rad: float = 1e-6


DEFAULT_EFFORT = Effort()


def solve_frame_ik(
    chain: Chain,
    frame: Transform,
    seed: Sequence[float] | None = None,
    *,
    parts: frozenset[Part] = frozenset(Part),
    first: First = POSITION_FIRST,
    effort: Effort = DEFAULT_EFFORT,
) -> Solution:
    """Return the posture that holds the tool at a frame, or as near to it as the chain comes.

    `parts` are asked for, `first` are met first where not all can be, in order. Raises as
    `check_transform` does for what is no frame.
    """
    return solve_goal(
        chain, frame_goal(frame, parts, position_of(chain.base)), seed, first=first, effort=effort
    )


def solve_pose_ik(
    chain: Chain,
    pose: Pose,
    seed: Sequence[float] | None = None,
    *,
    pitch_free: bool = False,
    roll_free: bool = False,
    roll_frame: RollFrame = RollFrame.HAND,
    first: First = POSITION_FIRST,
    effort: Effort = DEFAULT_EFFORT,
) -> Solution:
    """Return the posture for a five-axis pose, the hand in the plane of base axis and tip.

    `pitch_free` and `roll_free` leave that angle to the arm; with `first` = `PITCH_FIRST` the
    pitch is kept where the position cannot be. `roll_frame` says what the roll is counted from.
    """
    goal = pose_goal(
        pose,
        pitch_free=pitch_free,
        roll_free=roll_free,
        roll_frame=roll_frame,
        centre=position_of(chain.base),
    )
    return solve_goal(chain, goal, seed, first=first, effort=effort)


def solve_goal(
    chain: Chain,
    goal: Goal,
    seed: Sequence[float] | None = None,
    *,
    first: First = POSITION_FIRST,
    effort: Effort = DEFAULT_EFFORT,
) -> Solution:
    """Return the posture within the limits that meets a goal, or the best one found and why.

    The seed (by default the middle of the ranges) is tried first, so that a posture near it is
    found where there is one. Raises `KinematicsError` for a seed that does not fit the chain.
    """
    descent = Descent(chain, goal, first)
    start = _middle(chain) if seed is None else chain.clamp(seed)
    found = []
    tried = 0
    hopeless = beyond_reach(chain, goal)
    for values in _starts(
        chain, start, replace(effort, starts=min(effort.starts, 12)) if hopeless else effort
    ):
        tried += 1
        found.append(_turned(chain, descent.meet(values), start))
        if _met(chain, goal, found[-1], effort):
            return _account(chain, goal, found[-1], effort, tried)
    best = descent.best([_turned(chain, values, start) for values in descent.settle(found)])
    unlimited = None if hopeless else _without_limits(chain, goal, [best, *found[:3]], effort)
    if unlimited is not None and not chain.violations(unlimited):
        return _account(chain, goal, chain.clamp(unlimited), effort, tried)
    return _account(chain, goal, best, effort, tried, unlimited)


def descend(chain: Chain, goal: Goal, seed: Sequence[float]) -> Solution:
    """Return where one descent from the seed ends, for goals a small step away."""
    return _account(chain, goal, Descent(chain, goal, ()).meet(seed), DEFAULT_EFFORT, 1)


def _account(
    chain: Chain,
    goal: Goal,
    values: Sequence[float],
    effort: Effort,
    starts: int = 0,
    unlimited: Sequence[float] | None = None,
) -> Solution:
    return account(
        chain, goal, values, effort.tolerance_mm, effort.tolerance_rad, starts, unlimited
    )


def _met(chain: Chain, goal: Goal, values: Sequence[float], effort: Effort) -> bool:
    return _account(chain, goal, values, effort).ok


def _without_limits(
    chain: Chain, goal: Goal, starts: Sequence[tuple[float, ...]], effort: Effort
) -> tuple[float, ...] | None:
    """Return a posture that meets the goal if the limits are forgotten, to name those it breaks.

    Of several, the one that breaks them least.
    """
    if not any(link.has_limits for link in chain.links):
        return None
    free = replace(
        chain, links=tuple(replace(link, low=-math.inf, high=math.inf) for link in chain.links)
    )
    descent = Descent(free, goal, ())
    loose = replace(effort, starts=6)
    met = [
        turned
        for start in [*starts, *_starts(free, _middle(chain), loose)]
        if _met(free, goal, turned := _turned(chain, descent.meet(start), start), effort)
    ]
    return min(
        met,
        key=lambda values: sum(one.excess for one in chain.violations(values)),
        default=None,
    )


def _starts(chain: Chain, seed: tuple[float, ...], effort: Effort) -> Iterator[tuple[float, ...]]:
    """Yield the seed, the middle of the ranges, then random postures within them."""
    given = list(dict.fromkeys((seed, _middle(chain))))[: max(effort.starts, 1)]
    yield from given
    draw = random.Random(effort.random_seed)  # noqa: S311 - nothing secret is drawn
    ranges = [_range(chain, index) for index in range(len(chain))]
    for _ in range(effort.starts - len(given)):
        yield tuple(draw.uniform(low, high) for low, high in ranges)


def _range(chain: Chain, index: int) -> tuple[float, float]:
    """Return where a joint is looked for: its range, or one turn or arm's length without one."""
    low, high = chain.limits[index]
    revolute = chain.kinds[index] is JointKind.REVOLUTE
    span = math.pi if revolute else length_of(chain)
    if low == -math.inf:
        low = min(-span, high - 2.0 * span)
    if high == math.inf:
        high = max(span, low + 2.0 * span)
    if revolute and high - low > math.tau:
        return max(low, -math.pi), min(high, math.pi)
    return low, high


def _middle(chain: Chain) -> tuple[float, ...]:
    """Return the middle of the ranges; zero where a joint has no ends."""
    return tuple(
        (low + high) / 2.0 if math.isfinite(low) and math.isfinite(high) else 0.0
        for low, high in chain.limits
    )


def _turned(chain: Chain, values: Sequence[float], seed: Sequence[float]) -> tuple[float, ...]:
    """Return each turning joint on the turn, within its range, that is nearest to the seed."""
    return tuple(
        turn_into(value, low, high, near) if kind is JointKind.REVOLUTE else value
        for kind, value, (low, high), near in zip(
            chain.kinds, values, chain.limits, seed, strict=True
        )
    )
