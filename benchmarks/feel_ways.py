"""Lines and arcs that an arm can draw, of the kinds that are hard, and how far a point is off them.

Each kind is drawn by chance from a seed: a start posture, and what is asked from there. Only what
the driver's own planning allows is used; what it refuses is drawn anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from random import Random

import numpy as np

from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import ArmError
from armdrive.motion.execute import Moved
from armdrive.motion.plan import plan_line, plan_route
from armdrive.runtime.position import ArmCoordinates
from kinematics import Joints, KinematicsError, Pose
from kinematics.paths.routes import ArcPart
from tests.conformance.observation import Point, place
from tests.conformance.rows_moving import off_line_mm

TRIES = 2_000
"""So often is a kind drawn until one of it can be driven."""

STRAIGHT_DEG = (-8.0, -1.5)
"""An elbow between these is nearly stretched: the arm is beside its singularity."""
BESIDE_BASE_MM = 100.0
ROUNDING_RAD = 0.02
"""A start is not nearer to a limit than this: on whole steps it could be beyond."""


@dataclass(frozen=True, slots=True)
class Way:
    """One line, or one arc with a `via`: from a posture to a pose."""

    start: Joints
    start_pose: Pose
    goal: Pose
    via: Pose | None = None

    def off_mm(self, point: Point) -> float:
        """Return how far a point is from the ideal line or arc."""
        if self.via is None:
            return off_line_mm(point, place(self.start_pose), place(self.goal))
        return off_circle_mm(point, place(self.start_pose), place(self.via), place(self.goal))

    def begin(self, arm: Arm, speed: float) -> Handle[Moved]:
        """Have the arm draw it."""
        if self.via is None:
            return arm.move_l(self.goal, speed=speed, wait=False)
        return arm.move_c(self.via, self.goal, speed=speed, wait=False)

    def allowed(self, arm: Arm) -> bool:
        """Tell whether the driver would draw it."""
        here = ArmCoordinates(self.start, arm.parts.core.position.coordinates.opening_mm)
        try:
            if self.via is None:
                plan_line(arm.config, arm.parts.speeds, here, self.goal, 1.0)
            else:
                moves = [ArcPart(self.via, self.goal)]
                plan_route(arm.config, arm.parts.speeds, here, moves, 1.0)
        except (ArmError, KinematicsError):
            return False
        return True


def off_circle_mm(point: Point, a: Point, b: Point, c: Point) -> float:
    """Return the distance of a point from the circle through three others."""
    ab, ac, away = (np.subtract(each, a) for each in (b, c, point))
    normal = np.cross(ab, ac)
    towards = np.cross(normal, ab) * (ac @ ac) + np.cross(ac, normal) * (ab @ ab)
    centre = 0.5 * towards / (normal @ normal)  # seen from a, as all of these
    away = away - centre
    height = away @ normal / np.linalg.norm(normal)
    beside = math.sqrt(max(away @ away - height**2, 0.0)) - np.linalg.norm(centre)
    return math.hypot(beside, height)


# -- the kinds ----------------------------------------------------------------------------------

Draw = Callable[[Arm, Random], Way | None]


def _posture(arm: Arm, chance: Random, **fixed_deg: float) -> Joints:
    """Return a posture by chance, on whole steps; no joint turns by more than a quarter turn."""
    angles = {}
    for name, limit in zip(arm.model.arm.joint_names, arm.model.arm.limits, strict=True):
        low, high = max(limit.low_rad, -math.pi / 2), min(limit.high_rad, math.pi / 2)
        angles[name] = chance.uniform(low + ROUNDING_RAD, high - ROUNDING_RAD)
    angles |= {name: math.radians(angle) for name, angle in fixed_deg.items()}
    here, steps = arm.parts.core.position.coordinates, arm.parts.core.transmission
    wanted = here.joints.replace(**angles)
    return steps.to_joints(steps.to_motors(wanted, here.opening_mm))[0]


def _beside(pose: Pose, chance: Random, nearest_mm: float, furthest_mm: float) -> Pose:
    """Return a pose in any direction of another, the hand held alike."""
    away = [chance.gauss(0.0, 1.0) for _ in range(3)]
    share = chance.uniform(nearest_mm, furthest_mm) / math.hypot(*away)
    x_mm, y_mm, z_mm = (a + share * b for a, b in zip(place(pose), away, strict=True))
    return replace(pose, x_mm=x_mm, y_mm=y_mm, z_mm=z_mm)


def _long(arm: Arm, chance: Random) -> Way | None:
    start = _posture(arm, chance)
    pose = arm.model.arm.fk(start)
    return Way(start, pose, _beside(pose, chance, 150.0, 400.0))


def _short(arm: Arm, chance: Random) -> Way | None:
    start = _posture(arm, chance)
    pose = arm.model.arm.fk(start)
    return Way(start, pose, _beside(pose, chance, 3.0, 20.0))


def _near_singularity(arm: Arm, chance: Random) -> Way | None:
    start = _posture(arm, chance, elbow=chance.uniform(*STRAIGHT_DEG))
    pose = arm.model.arm.fk(start)
    return Way(start, pose, _beside(pose, chance, 40.0, 150.0))


def _near_base(arm: Arm, chance: Random) -> Way | None:
    start = _posture(arm, chance)
    pose = arm.model.arm.fk(start)
    goal = _beside(pose, chance, 60.0, 250.0)
    axis = (0.0, 0.0, 0.0)
    near = off_line_mm(axis, (pose.x_mm, pose.y_mm, 0.0), (goal.x_mm, goal.y_mm, 0.0))
    return Way(start, pose, goal) if near <= BESIDE_BASE_MM else None


def _turning(arm: Arm, chance: Random) -> Way | None:
    start = _posture(arm, chance)
    pose = arm.model.arm.fk(start)
    goal = replace(
        _beside(pose, chance, 40.0, 150.0),
        pitch_rad=pose.pitch_rad + math.radians(chance.choice((-1, 1)) * chance.uniform(20, 60)),
        roll_rad=pose.roll_rad + math.radians(chance.choice((-1, 1)) * chance.uniform(30, 90)),
    )
    return Way(start, pose, goal)


def _arc(arm: Arm, chance: Random) -> Way | None:
    start = _posture(arm, chance)
    pose = arm.model.arm.fk(start)
    via, goal = _beside(pose, chance, 25.0, 80.0), _beside(pose, chance, 40.0, 160.0)
    width = off_line_mm(place(via), place(pose), place(goal))
    return Way(start, pose, goal, via) if width > 10.0 else None


KINDS: dict[str, Draw] = {
    "long lines, 150 to 400 mm": _long,
    "short lines, 3 to 20 mm": _short,
    "lines beside the stretched elbow": _near_singularity,
    "lines beside the base": _near_base,
    "lines with pitch and roll": _turning,
    "arcs": _arc,
}


def ways(arm: Arm, kind: str, chance: Random, count: int) -> Iterator[Way]:
    """Draw so many ways of a kind that the driver allows."""
    for _ in range(count):
        for _ in range(TRIES):
            way = KINDS[kind](arm, chance)
            if way is not None and way.allowed(arm):
                yield way
                break
        else:
            raise RuntimeError(f"{kind}: none that the arm can drive in {TRIES} tries")
