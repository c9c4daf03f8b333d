"""The ways to hold the hand at a goal: which posture a motion takes, and why the others fall out.

Units: rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.goals import LineGoal
from armdrive.view import violation_text
from kinematics.five_axis.arm import Posture, postures

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from armdrive.goals import Goal, Ground
    from kinematics import Joints, Pose

SAME_RAD = 1e-4
"""Postures whose joints differ by less are the same one, but for the last digits of a path."""


@dataclass(frozen=True, slots=True)
class Way:
    """One posture at the goal; `against` says why it is not the one that would be taken.

    `allowed` tells whether the arm may stand like this: its joints are then a goal by themselves.
    """

    name: str
    joints: Joints
    taken: bool
    allowed: bool = True
    against: str = ""


def ways_of(ground: Ground, goal: Goal, pose: Pose | None, end: Joints | None) -> tuple[Way, ...]:
    """Return every posture for a pose, the taken one first; none where joints were asked for.

    `end` is the posture that the plan leads to, None where there is none.
    """
    if pose is None or (pose.yaw_rad is not None and not ground.config.model.arm.has_yaw):
        return ()
    found = postures(ground.config.model.arm, pose, ground.here.joints)
    line = isinstance(goal, LineGoal)
    ways = [_way(ground, each, end, line) for each in _different(found)]
    if end is not None and not any(way.taken for way in ways):
        ways.append(Way("", end, taken=True))  # of a way that turned a joint all the way round
    return tuple(sorted(ways, key=lambda way: not way.taken))


def _different(found: Sequence[Posture]) -> Iterator[Posture]:
    """Yield each posture once: the elbow of an arm that is stretched out is neither up nor down."""
    seen: list[Posture] = []
    for posture in found:
        if not any(_same(posture.joints, each.joints) for each in seen):
            seen.append(posture)
            yield posture


def _way(ground: Ground, posture: Posture, end: Joints | None, line: bool) -> Way:
    taken = end is not None and _same(posture.joints, end)
    if taken:
        return Way(posture.name, posture.joints, taken=True)
    forbidden = _forbidden(ground, posture)
    against = forbidden or _second_choice(ground, posture, end, line)
    return Way(posture.name, posture.joints, taken, not forbidden, against)


def _forbidden(ground: Ground, posture: Posture) -> str:
    """Say which limits or which guard keep the arm from standing like this."""
    if posture.violations:
        return "; ".join(map(violation_text, posture.violations))
    broken = ground.config.model.guards.violation(ground.config.model.arm, posture.joints)
    return "" if broken is None else broken.sentence


def _second_choice(ground: Ground, posture: Posture, end: Joints | None, line: bool) -> str:
    """Say why another posture is taken than one that is allowed."""
    if end is None:
        return "allowed at the goal, but not reached on this way"
    if line:
        return "allowed, but a straight line keeps the posture that it begins in"
    turn, least = (_turn_deg(ground.here.joints, one) for one in (posture.joints, end))
    return f"allowed, but further: its joints turn by {turn:.0f}° instead of {least:.0f}°"


def _same(a: Joints, b: Joints) -> bool:
    return all(abs(x - y) <= SAME_RAD for x, y in zip(a, b, strict=True))


def _turn_deg(a: Joints, b: Joints) -> float:
    """Return the measure by which the nearest posture is chosen, as an angle."""
    return math.degrees(math.dist(a.angles_rad, b.angles_rad))
