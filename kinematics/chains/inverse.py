"""Inverse kinematics of any chain, with limits and an honest account of what was not met.

In closed form where the chain has one and the goal is a whole frame; else numerically:
Levenberg-Marquardt steps (Marquardt, 1963) on the position error, counted in lengths of the arm,
and the rotation vector of the orientation error (Craig, chapter 5; Wampler, 1986), joints held at
a limit while the step points beyond it. What is answered is always measured again by the product
of the A matrices. Where not all can be met, the parts named first are met first. Lengths in mm,
angles in rad.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from kinematics.chains.chain import LIMIT_TOLERANCE_MM, Chain, JointViolation
from kinematics.chains.closed_form import ClosedForm, closed_form
from kinematics.chains.descent import SEARCHING, Descent
from kinematics.chains.goals import HEADING_FREE, Goal, Part, frame_goal, pose_goal
from kinematics.chains.jacobians import condition, length_of
from kinematics.chains.links import JointKind
from kinematics.errors import limit_sentence, require
from kinematics.frames.transforms import Transform, position_of
from kinematics.frames.vectors import distance, norm
from kinematics.limits import turn_into
from kinematics.spaces import Pose

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
    NO_POSTURE = "no posture meets the goal, for certain, with or without the joint limits"
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
    `starts` postures were tried, none where the closed form gave the answer.
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

    @property
    def ok(self) -> bool:
        """Whether everything asked is met."""
        return not self.missed

    @property
    def sentence(self) -> str:
        """What is missed, by how much, and why."""
        if self.ok:
            return self.reason.value
        parts = [f"position by {self.residual_mm:.3g} mm"] if Part.POSITION in self.missed else []
        parts += [
            f"{part.value} by {math.degrees(miss):.3g}°"
            for part, miss in self.misses_rad
            if part in self.missed
        ]
        text = f"missed: {', '.join(parts)}; {self.reason.value}"
        if self.reason is Reason.JOINT_LIMIT:
            text += ": " + "; ".join(
                limit_sentence(one.joint, one.value, one.bound, one.unit) for one in self.violations
            )
        if self.reason is Reason.NOT_FOUND:
            text += f" ({self.starts} starts, which is no proof that there is none)"
        return text


def _account(
    chain: Chain,
    goal: Goal,
    values: Sequence[float],
    effort: Effort,
    starts: int = 0,
    unlimited: Sequence[float] | None = None,
    *,
    certain: bool = False,
) -> Solution:
    """Return the account of a posture; `unlimited` is one that meets the goal without limits.

    `certain` says that no posture meets it otherwise.
    """
    joints = tuple(values)
    frame = chain.fk(joints)
    asked_position = Part.POSITION in goal.parts
    residual_mm = distance(position_of(frame), position_of(goal.frame)) if asked_position else 0.0
    turn, split = goal.turn(frame)
    misses = tuple((part, abs(miss)) for part, _, miss in split)
    residual_rad = norm(turn)
    missed = {part for part, miss in misses if miss > effort.tolerance_rad}
    if residual_mm > effort.tolerance_mm:
        missed.add(Part.POSITION)
    if residual_rad > math.sqrt(3.0) * effort.tolerance_rad and not missed - {Part.POSITION}:
        missed |= {part for part, _ in misses}  # a turn that the split does not show
    broken = chain.violations(joints if unlimited is None else unlimited)
    reason = _reason(chain, goal, joints, missed, broken, unlimited is not None)
    if reason is Reason.NOT_FOUND and certain:
        reason = Reason.NO_POSTURE
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
    `random_seed`, so that the same question always has the same answer. A whole frame, or
    one of any heading, is first looked for by up to `searches` short descents. A part is met
    within `tolerance_mm` or `tolerance_rad`.
    """

    starts: int = 24
    searches: int = 200
    random_seed: int = 1
    tolerance_mm: float = 1e-4
    tolerance_rad: float = 1e-6


DEFAULT_EFFORT = Effort()

MOST_BRANCHES = 8
"""How many of the postures beyond limits are looked around for one within them."""


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
    first: First = POSITION_FIRST,
    effort: Effort = DEFAULT_EFFORT,
) -> Solution:
    """Return the posture for a five-axis pose, the hand in the plane of base axis and tip.

    `pitch_free` and `roll_free` leave that angle to the arm; with `first` = `PITCH_FIRST` the
    pitch is kept where the position cannot be.
    """
    centre = position_of(chain.base)
    goal = pose_goal(pose, pitch_free=pitch_free, roll_free=roll_free, centre=centre)
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
    require("a chain", chain, Chain, "Chain((DHLink(a_mm=200.0),))")
    require("a goal", goal, Goal, "frame_goal(frame)")
    start = middle(chain) if seed is None else chain.clamp(seed)
    closed = closed_form(chain)
    if closed is None or not closed.solves(goal):
        return _search(chain, goal, start, first, effort)
    found = closed.nearest(goal, start)
    if found is not None:
        return _account(chain, goal, found, effort)
    return _search(chain, goal, start, first, effort, closed)


def _search(
    chain: Chain,
    goal: Goal,
    start: tuple[float, ...],
    first: First,
    effort: Effort,
    closed: ClosedForm | None = None,
) -> Solution:
    """Return the best posture found by descents; a closed form has none within the limits.

    Where its postures break limits, a singular one may have others that keep them, and the nearest
    pose is near one of them: descents begin there.
    """
    branches = [] if closed is None else closed.branches(goal, start)
    certain = closed is not None and closed.complete and not branches
    tried = 0
    hopeless = certain or beyond_reach(chain, goal)
    incomplete = closed is None or not closed.complete
    if incomplete and goal.parts >= HEADING_FREE and not hopeless:
        tried, found = _postures_of_hand(chain, goal, start, effort)
        branches = [*branches, *found]
        if branches and not chain.violations(branches[-1]):
            return _account(chain, goal, chain.clamp(branches[-1]), effort, tried)
    descent = Descent(chain, goal, first)
    looks = replace(effort, starts=min(effort.starts, 12)) if hopeless else effort
    ends = []
    for values in (*map(chain.clamp, branches[:MOST_BRANCHES]), *_starts(chain, start, looks)):
        tried += 1
        ends.append(_turned(chain, descent.meet(values), start))
        if _met(chain, goal, ends[-1], effort):
            return _account(chain, goal, ends[-1], effort, tried)
    best = descent.best([_turned(chain, values, start) for values in descent.settle(ends)])
    if branches:
        unlimited = _least_broken(chain, branches)
    else:
        near = [best, *ends[:3]]
        unlimited = None if hopeless else _without_limits(chain, goal, near, effort)
    if unlimited is not None and not chain.violations(unlimited):
        return _account(chain, goal, chain.clamp(unlimited), effort, tried)
    return _account(chain, goal, best, effort, tried, unlimited, certain=certain)


def _postures_of_hand(
    chain: Chain, goal: Goal, start: tuple[float, ...], effort: Effort
) -> tuple[int, list[tuple[float, ...]]]:
    """Return postures that meet a hand's goal, found by many short descents without limits.

    The first within the limits is the last. With them comes how many descents there were: each is
    over in half a millisecond, of six joints every second one succeeds, and the hardest goals take
    some dozens.
    """
    descent = Descent(chain, goal, limited=False)
    found: list[tuple[float, ...]] = []
    tried = 0
    for values in _starts(chain, start, replace(effort, starts=effort.searches)):
        tried += 1
        end = descent.met(values, SEARCHING)
        if end is None:
            continue
        turned = _turned(chain, end, start)
        if not _met(chain, goal, turned, effort):
            continue
        found.append(turned)
        if not chain.violations(turned):
            break
    return tried, found


def descend(chain: Chain, goal: Goal, seed: Sequence[float]) -> Solution:
    """Return where one descent from the seed ends, for goals a small step away."""
    return _account(chain, goal, Descent(chain, goal).meet(seed), DEFAULT_EFFORT, 1)


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
    free = chain.within()
    descent = Descent(free, goal)
    loose = replace(effort, starts=6)
    met = [
        turned
        for start in [*starts, *_starts(free, middle(chain), loose)]
        if _met(free, goal, turned := _turned(chain, descent.meet(start), start), effort)
    ]
    return _least_broken(chain, met)


def _least_broken(chain: Chain, postures: Iterable[tuple[float, ...]]) -> tuple[float, ...] | None:
    """Return the posture that breaks limits least; None of none."""
    return min(
        postures,
        key=lambda values: sum(one.excess for one in chain.violations(values)),
        default=None,
    )


def _starts(chain: Chain, seed: tuple[float, ...], effort: Effort) -> Iterator[tuple[float, ...]]:
    """Yield the seed, the middle of the ranges, then random postures within them."""
    given = list(dict.fromkeys((seed, middle(chain))))[: max(effort.starts, 1)]
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


def middle(chain: Chain) -> tuple[float, ...]:
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
