"""Mirrors, shifts and turns points; every new point is checked.

Units: mm and rad. The frame is the arm's base: x forwards, y to the left, z up. A point beyond a
joint's limit or within a guard, or that cannot be reached, is refused by its name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

from armdrive.config.arm import ArmConfig
from armdrive.errors import OutOfBounds, Refused
from armdrive.motion.plan import guard_error, limit_error
from armdrive.storage.points import Point
from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry
from kinematics.spaces import Joints, Pose

# The largest distance between the points of equal postures.
SAME_MM = 1e-6

Spot = tuple[float, float, float]

# Makes one posture of another; may raise `KinematicsError` or `Refused`.
Shape = Callable[[Joints], Joints]


@dataclass(frozen=True, slots=True)
class Offset:
    """A turn about the base axis, anticlockwise from above, and then a shift along the base's axes.

    Pitch and roll of the hand stay, and so does its direction on an arm whose poses have one.
    """

    x_mm: float = 0.0
    y_mm: float = 0.0
    z_mm: float = 0.0
    turn_rad: float = 0.0

    def __str__(self) -> str:
        words = f"{self.x_mm:g}, {self.y_mm:g}, {self.z_mm:g} mm"
        return words + f" and {math.degrees(self.turn_rad):g}°" * bool(self.turn_rad)


def mirrored(config: ArmConfig, joints: Joints) -> Joints:
    """Return the posture on the other side of the arm's x-z plane, left for right.

    On a symmetric arm some joints turn the other way; trying all combinations finds which. On any
    other arm the hand is brought to the mirrored pose. Raises `Unreachable`.
    """
    arm = config.model.arm
    wanted = [(x, -y, z) for x, y, z in arm.points(joints)]
    signs = product((1.0, -1.0), repeat=len(joints))
    tried = (Joints(_times(joints, each), joints.names) for each in signs)
    nearest = min(tried, key=lambda each: _apart(arm.points(each), wanted))
    pose = _mirrored_pose(arm.fk(joints))
    nearest = _rolled(arm, nearest, pose)
    if _apart(arm.points(nearest), wanted) < SAME_MM and _same_pose(arm.fk(nearest), pose):
        return nearest
    return arm.ik(pose, nearest)


def offset(config: ArmConfig, joints: Joints, by: Offset) -> Joints:
    """Return the posture turned about the base axis and shifted. Raises `Unreachable`."""
    arm = config.model.arm
    turned = joints
    if by.turn_rad:
        turned = Joints((joints[0] + by.turn_rad, *tuple(joints)[1:]), joints.names)
        cos, sin = math.cos(by.turn_rad), math.sin(by.turn_rad)
        wanted = [(cos * x - sin * y, sin * x + cos * y, z) for x, y, z in arm.points(joints)]
        if _apart(arm.points(turned), wanted) > SAME_MM:
            raise Refused("the first joint of this arm does not turn it about the base's z axis")
    if not (by.x_mm or by.y_mm or by.z_mm):
        return turned
    pose = arm.fk(turned)
    there = replace(
        pose, x_mm=pose.x_mm + by.x_mm, y_mm=pose.y_mm + by.y_mm, z_mm=pose.z_mm + by.z_mm
    )
    return arm.ik(there, turned)


def derived(config: ArmConfig, name: str, point: Point, shape: Shape, note: str = "") -> Point:
    """Return the point that a shape makes of another, called `name`; the note says where from.

    Raises `OutOfBounds` or `Refused` with that name.
    """
    try:
        joints = shape(point.joints)
    except (KinematicsError, Refused) as error:
        raise Refused(f"the point {name!r} cannot go there: {error}") from error
    _require_allowed(config, name, joints)
    notes = "; ".join(text for text in (point.note, note) if text)
    return Point(joints, point.opening_mm, notes)


def _require_allowed(config: ArmConfig, name: str, joints: Joints) -> None:
    model = config.model
    beyond = model.arm.violations(joints)
    broken = model.guards.violation(model.arm, joints)
    if beyond:
        error = limit_error(beyond[0])
    elif broken is not None:
        error = guard_error(broken, 1.0)
    else:
        return
    raise OutOfBounds(
        f"the point {name!r} cannot go there: {error}",
        name=error.name,
        value=error.value,
        bound=error.bound,
    )


def _mirrored_pose(pose: Pose) -> Pose:
    yaw = None if pose.yaw_rad is None else -pose.yaw_rad
    return replace(pose, y_mm=-pose.y_mm, roll_rad=-pose.roll_rad, yaw_rad=yaw)


def _rolled(arm: ArmGeometry, joints: Joints, pose: Pose) -> Joints:
    """Turn the last joint the other way if the mirrored hand needs it.

    The last joint turns the hand, which the points of an arm do not show.
    """
    other = Joints((*tuple(joints)[:-1], -joints[-1]), joints.names)
    return min((joints, other), key=lambda each: _turned(arm.fk(each), pose))


def _turned(a: Pose, b: Pose) -> float:
    return abs(math.remainder(a.roll_rad - b.roll_rad, math.tau))


def _same_pose(a: Pose, b: Pose) -> bool:
    tilt = abs(math.remainder(a.pitch_rad - b.pitch_rad, math.tau))
    return max(_turned(a, b), tilt) < SAME_MM


def _times(joints: Joints, signs: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(angle * sign + 0.0 for angle, sign in zip(joints, signs, strict=True))


def _apart(a: Sequence[Spot], b: Sequence[Spot]) -> float:
    """Return the largest distance between two lists of points, in mm."""
    return max(math.dist(p, q) for p, q in zip(a, b, strict=True))
