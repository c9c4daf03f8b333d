"""Where the arm could go instead of a goal that is refused: near it, or as far as the way is free.

Units: mm, rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.errors import ArmError
from armdrive.goals import JointGoal, LineGoal, PoseGoal, PostureGoal
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from collections.abc import Callable

    from armdrive.goals import Goal, Ground
    from armdrive.planning import Plan
    from kinematics import Joints, Pose

HALVINGS = 10
"""A way is halved so often: its end is then known to a thousandth of it."""

LEAST_TURN_RAD = math.radians(0.05)
"""What turns no joint by this much leads nowhere."""


LEAST_SHARE = 0.05
"""Less of the way than this is no help to anybody who wants to go it."""


@dataclass(frozen=True, slots=True)
class Furthest:
    """A pose, and the posture in it, that the arm can be moved to, as a plan has shown.

    `share` is how much of the way that was asked for leads there; 1 for the goal's neighbour.
    """

    pose: Pose
    joints: Joints
    share: float = 1.0


def instead_of(
    ground: Ground, goal: Goal, refusal: ArmError | KinematicsError | None, fraction: float
) -> Furthest | None:
    """Return where a motion could lead instead; None where every way is barred.

    The nearest pose that the refusal names, if it can be gone to, else as far along the way that
    was asked for as limits and guards leave it free.
    """
    near = getattr(refusal, "nearest", None)
    if near is not None:
        same_way = LineGoal(near) if isinstance(goal, LineGoal) else PoseGoal(near)
        for each in (same_way, PoseGoal(near)):
            plan = _plan(ground, each, fraction)
            if plan is not None:
                return _furthest(ground, plan.end.joints, 1.0)
    part = _parts(ground, goal, near)
    return None if part is None else _furthest_along(ground, part, fraction)


def _parts(ground: Ground, goal: Goal, near: Pose | None) -> Callable[[float], Goal] | None:
    """Return what leads to a share of the way that was asked for."""
    arm, here = ground.config.model.arm, ground.here
    if isinstance(goal, LineGoal):
        try:
            line = arm.line(here.joints, goal.pose(ground))
        except KinematicsError:
            return None
        return lambda share: LineGoal(line.pose(share))
    end = goal.joints(ground) if isinstance(goal, JointGoal | PostureGoal) else None
    if end is None:
        pose = near or goal.pose(ground)
        end = None if pose is None else arm.solve(pose, here.joints)
    if end is None:
        return None
    return lambda share: PostureGoal(_between(here.joints, end, share))


def _furthest_along(
    ground: Ground, part: Callable[[float], Goal], fraction: float
) -> Furthest | None:
    low, high, best = 0.0, 1.0, None
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        plan = _plan(ground, part(middle), fraction)
        if plan is None:
            high = middle
        else:
            low, best = middle, plan
    if best is None or low < LEAST_SHARE:
        return None
    found = _furthest(ground, best.end.joints, low)
    moved = zip(found.joints, ground.here.joints, strict=True)
    return found if max(abs(b - a) for a, b in moved) >= LEAST_TURN_RAD else None


def _plan(ground: Ground, goal: Goal, fraction: float) -> Plan | None:
    try:
        return goal.plan(ground, fraction)
    except (ArmError, KinematicsError):
        return None


def _furthest(ground: Ground, joints: Joints, share: float) -> Furthest:
    return Furthest(ground.config.model.arm.fk(joints), joints, share)


def _between(start: Joints, end: Joints, share: float) -> Joints:
    return start.replace(
        **{name: start[name] + (end[name] - start[name]) * share for name in start.names}
    )
