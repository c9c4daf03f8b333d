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

from kinematics.chains import Chain
from kinematics.five_axis import RollFrame
from kinematics.frames import Transform, position_of
from kinematics.goals import Goal, Part, frame_goal, pose_goal
from kinematics.ik_account import Solution, account, beyond_reach
from kinematics.ik_descent import Descent
from kinematics.limits import turn_into
from kinematics.links import JointKind
from kinematics.singularities import length_of
from kinematics.spaces import Pose

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
