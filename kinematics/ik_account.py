"""The account of a numerical solution: what was met, what was missed, by how much, and why.

Measured by the product of the A matrices, not by what the solver believes. Lengths in mm, angles
in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from kinematics.chains import LIMIT_TOLERANCE_MM, Chain, JointViolation
from kinematics.frames import Transform, position_of
from kinematics.goals import Goal, Part
from kinematics.links import JointKind
from kinematics.singularities import condition
from kinematics.vectors import distance, norm

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
