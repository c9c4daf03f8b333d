"""Inverse kinematics of any chain within its limits, with an account of what was not met.

`solve_goal` asks the closed form, where the chain has one for this kind of goal. If that has no
posture within the limits, or there is none, `_Question.search` looks for one by descents
(`descent`), and `_Question.account` says of the best posture what it misses and why.

The residuals in an answer are always computed from the product of the A matrices, whatever found
the posture. If not all parts of a goal can be met, some have priority. Sources of the numerical
solution: Marquardt, 1963; Craig, chapter 5, and Wampler, 1986, for the orientation error. Lengths
in mm, angles in rad.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from kinematics.chains.chain import LIMIT_TOLERANCE_MM, Chain
from kinematics.chains.closed_form import closed_form
from kinematics.chains.descent import SEARCHING, THOROUGH, Descent, Weights
from kinematics.chains.goals import ALL_PARTS, Goal, Part, frame_goal
from kinematics.chains.jacobians import length_of
from kinematics.chains.links import JointKind
from kinematics.errors import limit_sentence, require
from kinematics.frames.transforms import Transform, position_of
from kinematics.frames.vectors import distance, norm
from kinematics.limits import LimitViolation
from kinematics.text import significant


class Reason(Enum):
    """Why a goal was not met; the value says how sure that is."""

    NONE = "the goal is met"
    BEYOND_REACH = "the goal is further away than all links together are long, for certain"
    JOINT_LIMIT = "without the joint limits the goal is met; no posture within them was found"
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
    violations: tuple[LimitViolation, ...]
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
        parts = (
            [f"position by {significant(self.residual_mm)} mm"]
            if Part.POSITION in self.missed
            else []
        )
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


def beyond_reach(chain: Chain, goal: Goal) -> bool:
    """Whether a goal is too far away for certain."""
    centre, radius = chain.reach_sphere
    return Part.POSITION in goal.parts and (
        distance(centre, position_of(goal.frame)) > radius * (1.0 + 1e-9)
    )


def _at_limit(chain: Chain, joints: Sequence[float]) -> tuple[str, ...]:
    return tuple(
        name
        for name, value, bounds in zip(chain.joint_names, joints, chain.limits, strict=True)
        if min(abs(value - bound) for bound in bounds) <= LIMIT_TOLERANCE_MM
    )


# How much the parts that come first outweigh the others where not all can be met, step by step: the
# largest weight at once would make the valley of the error too narrow to follow.
STIFF = (10.0, 100.0, 1e3, 1e4)

# How many of the postures found are followed that far.
MOST_SETTLED = 4

# Postures tried: the seed, the middle of the ranges, then random ones, always the same.
STARTS = 24

# The most that are tried for a goal that no posture meets: only the nearest pose is wanted.
HOPELESS_STARTS = 12

# Short descents without limits that look for postures which meet the goal.
SEARCHES = 200

# A part of a goal is met within this.
MET_MM, MET_RAD = 1e-4, 1e-6

# How many of the postures beyond limits are looked around for one within them.
MOST_BRANCHES = 8


def solve_frame_ik(
    chain: Chain,
    frame: Transform,
    seed: Sequence[float] | None = None,
    *,
    parts: frozenset[Part] = ALL_PARTS,
) -> Solution:
    """Return the posture that holds the tool at a frame, or as near to it as the chain comes.

    `parts` are asked for. Raises as `check_transform` does for what is no frame.
    """
    return solve_goal(chain, frame_goal(frame, parts, position_of(chain.base)), seed)


def solve_goal(
    chain: Chain,
    goal: Goal,
    seed: Sequence[float] | None = None,
    *,
    hand_first: bool = False,
    starts: int = STARTS,
) -> Solution:
    """Return the posture within the limits that meets a goal, or the best one found and why.

    The seed (by default the middle of the ranges) is tried first, so that a posture near it is
    found where there is one. Where not all can be met, the position is met and the hand turned as
    nearly as it goes, or with `hand_first` the other way round. Raises `KinematicsError` for a seed
    that does not fit the chain.
    """
    require("a chain", chain, Chain, "Chain((DHLink(a_mm=200.0),))")
    require("a goal", goal, Goal, "frame_goal(frame)")
    start = middle(chain) if seed is None else chain.clamp(seed)
    question, closed = _Question(chain, goal, starts), closed_form(chain)
    if closed is None or not closed.solves(goal):
        return question.search(start, None, hand_first=hand_first)
    found = closed.nearest(goal, start)
    if found is not None:
        return question.account(found)
    return question.search(start, closed.branches(goal, start), hand_first=hand_first)


class _Miss(NamedTuple):
    """How far a frame is from a goal: the parts missed, mm, rad, and the rad split into parts."""

    parts: set[Part]
    mm: float
    rad: float
    split: tuple[tuple[Part, float], ...]


@dataclass(frozen=True, slots=True)
class _Question:
    """A goal that is asked of a chain, and from how many postures to look for it."""

    chain: Chain
    goal: Goal
    starts: int = STARTS

    def miss(self, frame: Transform) -> _Miss:
        """Return how far a frame is from the goal."""
        goal = self.goal
        asked_position = Part.POSITION in goal.parts
        mm = distance(position_of(frame), position_of(goal.frame)) if asked_position else 0.0
        turn, split = goal.turn(frame)
        misses = tuple((part, abs(miss)) for part, _, miss in split)
        rad = norm(turn)
        missed = {part for part, miss in misses if miss > MET_RAD}
        if rad > math.sqrt(3.0) * MET_RAD and not missed:
            missed |= {part for part, _ in misses}  # a turn that the split does not show
        if mm > MET_MM:
            missed.add(Part.POSITION)
        return _Miss(missed, mm, rad, misses)

    def met(self, values: Sequence[float]) -> bool:
        """Whether a posture meets the goal, whatever the limits."""
        return not self.miss(self.chain.fk(values)).parts

    def account(
        self,
        values: Sequence[float],
        starts: int = 0,
        unlimited: Sequence[float] | None = None,
        *,
        certain: bool = False,
    ) -> Solution:
        """Return the account of a posture; `unlimited` is one that meets the goal without limits.

        `certain` says that no posture meets it otherwise.
        """
        chain, goal, joints = self.chain, self.goal, tuple(values)
        frame = chain.fk(joints)
        miss = self.miss(frame)
        broken = chain.violations(joints if unlimited is None else unlimited)
        if not miss.parts:
            reason = Reason.NONE
        elif beyond_reach(chain, goal):
            reason = Reason.BEYOND_REACH
        elif unlimited is not None and broken:
            reason = Reason.JOINT_LIMIT
        else:
            reason = Reason.NO_POSTURE if certain else Reason.NOT_FOUND
        return Solution(
            joints,
            frame,
            goal.parts - miss.parts,
            frozenset(miss.parts),
            miss.mm,
            miss.rad,
            miss.split,
            reason,
            broken if miss.parts else (),
            _at_limit(chain, joints),
            starts,
        )

    def search(
        self,
        start: tuple[float, ...],
        known: Sequence[tuple[float, ...]] | None,
        *,
        hand_first: bool,
    ) -> Solution:
        """Return the best posture that descents find.

        `known` are all postures that meet the goal, each beyond a limit, where a closed form tells
        them; None where it does not.
        """
        chain, goal = self.chain, self.goal
        certain = known is not None and not known
        hopeless = certain or beyond_reach(chain, goal)
        descent = Descent(chain, goal)
        ends = [descent.run(start, THOROUGH).values]
        if self.met(ends[0]):
            return self.account(ends[0], 1)
        tried, branches = 1, list(known or ())
        if known is None and not hopeless:
            searched, branches = self.without_limits(start)
            tried += searched
            if branches and not chain.violations(branches[-1]):
                return self.account(chain.clamp(branches[-1]), tried)
        # Descents within the limits come nearest to the goal. They begin near postures that meet
        # it beyond a limit: the nearest pose is near one of them, and a singular one may share the
        # turn of two joints in another way, which keeps the limits.
        looks = min(self.starts, HOPELESS_STARTS) if hopeless else self.starts
        for values in (*map(chain.clamp, branches[:MOST_BRANCHES]), *_starts(chain, start, looks)):
            tried += 1
            ends.append(chain.turned(descent.run(values, THOROUGH).values, start))
            if self.met(ends[-1]):
                return self.account(ends[-1], tried)
        # The goal is missed: the parts that come first are met as nearly as they can be.
        first = [Weights(hand=one) if hand_first else Weights(position=one) for one in STIFF]
        ranked = sorted(ends, key=lambda values: descent.cost(values, first[0]))
        settled = []
        for values in [ends[0], *ranked[:MOST_SETTLED]]:
            for weights in first:
                values = descent.run(values, THOROUGH, weights).values
            settled.append(chain.turned(values, start))
        best = min(settled, key=lambda values: descent.cost(values, first[-1]))
        # Of the postures that meet it without limits, one tells which limit is at fault.
        least = min(branches, key=self._excess, default=None)
        return self.account(best, tried, least, certain=certain)

    def without_limits(self, start: tuple[float, ...]) -> tuple[int, list[tuple[float, ...]]]:
        """Return postures that meet the goal, found by many short descents without limits.

        The first within the limits is the last. With them comes how many descents there were: each
        is over in half a millisecond, of six joints every second one succeeds, and the hardest
        goals take some dozens.
        """
        chain, descent = self.chain, Descent(self.chain, self.goal, limited=False)
        found: list[tuple[float, ...]] = []
        tried = 0
        for values in _starts(chain, start, SEARCHES):
            tried += 1
            end = descent.met(values, SEARCHING)
            if end is not None and self.met(turned := chain.turned(end, start)):
                found.append(turned)
                if not chain.violations(turned):
                    break
        return tried, found

    def _excess(self, values: Sequence[float]) -> float:
        return sum(one.excess for one in self.chain.violations(values))


def descend(chain: Chain, goal: Goal, seed: Sequence[float]) -> Solution:
    """Return where one descent from the seed ends, for goals a small step away."""
    return _Question(chain, goal).account(Descent(chain, goal).run(seed, THOROUGH).values, 1)


def _starts(chain: Chain, seed: tuple[float, ...], count: int) -> Iterator[tuple[float, ...]]:
    """Yield the seed, the middle of the ranges, then random postures within them."""
    given = list(dict.fromkeys((seed, middle(chain))))[: max(count, 1)]
    yield from given
    draw = random.Random(1)  # noqa: S311 - nothing secret is drawn
    ranges = [_range(chain, index) for index in range(len(chain))]
    for _ in range(count - len(given)):
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
