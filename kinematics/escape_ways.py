"""Ways out of one guard on the arm's links or on a sum of its joints, as poses to try next.

Lengths in mm. The hand is moved as if the link went with it; where that is not so, the next of
several moves mends it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from kinematics.errors import Unreachable
from kinematics.guards import GuardedArm, Violation
from kinematics.guards_links import BOX
from kinematics.spaces import Joints, Pose

PROBE_MM = 0.5
"""How far a pose is moved to see which way leads out."""

BEYOND = 1.01
"""How much further than just out: the last digits are nobody's."""

FURTHEST_MM = 300.0
"""The furthest that one move leads, where hardly any way seems to lead out."""


def out_of_box(
    guarded: GuardedArm, violation: Violation, pose: Pose, joints: Joints
) -> Iterator[Pose]:
    """Yield the poses that take a link out of a box by each of its sides."""
    links = guarded.links
    if links is None:
        return
    box = next(one for one in links.boxes if BOX + one.name == violation.guard)
    index = links.names.index(violation.quantity)
    a, b = links.segments(guarded.arm.points(joints))[index]
    for dx, dy, dz in box.ways_out_mm(a, b, links.radii_mm[index]):
        yield replace(pose, x_mm=pose.x_mm + dx, y_mm=pose.y_mm + dy, z_mm=pose.z_mm + dz)


def steepest(
    guarded: GuardedArm, violation: Violation, pose: Pose, joints: Joints
) -> Iterator[Pose]:
    """Yield the pose that leaves a guard by the way on which it gets shallower fastest."""
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    here = guarded.arm.fk(joints)
    slopes = [
        (_depth_mm(guarded, violation, _moved(here, axis, PROBE_MM), joints) - violation.excess_mm)
        / PROBE_MM
        for axis in axes
    ]
    steep = math.hypot(*slopes)
    if steep > 0.0:
        way = min(BEYOND * violation.excess_mm / steep, FURTHEST_MM)
        x, y, z = (-slope / steep for slope in slopes)
        yield _moved(pose, (x, y, z), way)


def at_radius(pose: Pose, radius: float, direction: float) -> Pose:
    """Return the pose moved to a distance from the base axis, in a direction from it."""
    return replace(pose, x_mm=radius * math.cos(direction), y_mm=radius * math.sin(direction))


def distance_mm(a: Pose, b: Pose) -> float:
    """Return the distance of the finger tips in two poses."""
    return math.dist((a.x_mm, a.y_mm, a.z_mm), (b.x_mm, b.y_mm, b.z_mm))


def _depth_mm(guarded: GuardedArm, violation: Violation, pose: Pose, seed: Joints) -> float:
    """Return how deep a pose is in one guard; out of reach, as deep as the violation says."""
    try:
        joints = guarded.arm.ik_near(pose, seed)
    except Unreachable:
        return violation.excess_mm
    same = (violation.guard, violation.quantity)
    broken = guarded.violations(joints)
    return sum(one.excess_mm for one in broken if (one.guard, one.quantity) == same)


def _moved(pose: Pose, way: tuple[float, float, float], by_mm: float) -> Pose:
    x, y, z = way
    return replace(
        pose, x_mm=pose.x_mm + by_mm * x, y_mm=pose.y_mm + by_mm * y, z_mm=pose.z_mm + by_mm * z
    )
