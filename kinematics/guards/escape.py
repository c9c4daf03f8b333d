"""The nearest pose that is both in reach and outside every guard. Lengths in mm, angles in rad."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from kinematics.geometry import AXIS_MM, ArmGeometry, Unreachable
from kinematics.guards import BOX, GuardedArm, Guards, GuardViolation
from kinematics.spaces import Joints, Pose

# Ways out of a guard on the arm's links or on a sum of its joints, as poses to try next. The hand
# is moved as if the link moved with it. That is inaccurate, but later moves correct it.

# How far a pose is moved to measure the slope of a guard's depth.
PROBE_MM = 0.5

# How much further than the bound to move, so that rounding does not matter.
BEYOND = 1.01

# The longest single move, for guards whose depth hardly changes in any direction.
FURTHEST_MM = 300.0


def out_of_box(
    guarded: GuardedArm, violation: GuardViolation, pose: Pose, joints: Joints
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
    guarded: GuardedArm, violation: GuardViolation, pose: Pose, joints: Joints
) -> Iterator[Pose]:
    """Yield the pose that leaves a guard in the direction in which its depth decreases fastest."""
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
    """Return the distance between the finger tips in two poses."""
    return math.dist(a.position_mm, b.position_mm)


def _depth_mm(guarded: GuardedArm, violation: GuardViolation, pose: Pose, seed: Joints) -> float:
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


# How many bounds a goal is moved to in turn before the attempt is given up.
MOVES = 4

# How many goals are tried after each move, the nearest ones first.
MOST_TRIES = 12

# How often the path back to the arm's present pose is halved, if nothing else was found.
HALVINGS = 12

# A goal, and the posture near which to look for it.
Try = tuple[Pose, Joints | None]


def nearest_allowed(
    arm: ArmGeometry, guards: Guards, pose: Pose, seed: Joints | None = None
) -> Pose | None:
    """Return a reachable pose near `pose` that violates no guard, with its pitch and roll if any.

    The goal is moved to the bounds of the guards that it violates, separately and one after
    another, each time to the nearest pose in reach. Of the poses that `arm.ik` then solves (with
    this seed) outside every guard, the one nearest to the goal is returned. If `MOVES` such moves
    find none, the result is the furthest allowed pose on the straight path from the seed's pose, or
    None if there is no allowed seed. If a single guard on points of the arm is violated and its
    bound is in reach, the answer is exact; for a guard on links it is near the bound.
    """
    search = _Search(arm, guards.over(arm), pose, seed)
    seen: set[Pose] = set()
    tries: list[Try] = [(pose, None)]
    for _ in range(MOVES + 1):
        following = [found for goal, nearby in tries for found in search.look(goal, nearby)]
        following.sort(key=lambda one: distance_mm(one[0], pose))
        tries = [one for one in following if _new(one[0], seen)][:MOST_TRIES]
    return search.best or search.on_the_way()


@dataclass(slots=True, eq=False)
class _Search:
    """The best pose so far, and where to go from a pose that is not allowed."""

    arm: ArmGeometry
    guarded: GuardedArm
    pose: Pose
    seed: Joints | None
    best: Pose | None = None
    least_mm: float = math.inf

    def look(self, goal: Pose, nearby: Joints | None) -> Iterator[Try]:
        """Keep the reachable pose nearest to a goal if it is allowed; otherwise yield ways out."""
        near = self._in_reach(goal, nearby)
        joints = self.arm.solve(near, self.seed)
        if joints is None:  # pragma: no cover - a reachable pose has a posture
            return
        broken = self.guarded.violations(joints)
        away_mm = distance_mm(near, self.pose)
        if not broken and away_mm < self.least_mm:
            self.best, self.least_mm = near, away_mm
        for violation in broken:
            for start in (goal, near):
                for escape in self._escapes(violation, start, joints):
                    yield escape, joints

    def _in_reach(self, goal: Pose, nearby: Joints | None) -> Pose:
        """Return a goal, or the reachable pose near it, looked for near a posture if one is given.

        An arm that is solved numerically takes long to be sure that there is no posture.
        """
        if nearby is None:
            return self.arm.nearest_pose(goal, self.seed)
        try:
            self.arm.ik_near(goal, nearby)
        except Unreachable as refusal:
            return refusal.nearest or goal
        return goal

    def on_the_way(self) -> Pose | None:
        """Return an allowed pose between the seed's and the goal; None without an allowed seed."""
        if self.seed is None or self.guarded.violations(self.seed):
            return None
        found, nearby = self.arm.fk(self.seed), self.seed
        start, low, high = found, 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            there = _between(start, self.pose, middle)
            joints = self._allowed(there, nearby)
            if joints is None:
                high = middle
            else:
                low, found, nearby = middle, there, joints
        return found

    def _allowed(self, pose: Pose, nearby: Joints) -> Joints | None:
        """Return the posture that `arm.ik` gives for a pose; None if it is not allowed."""
        try:
            self.arm.ik_near(pose, nearby)
        except Unreachable:
            return None
        joints = self.arm.solve(pose, self.seed)
        return None if joints is None or self.guarded.violations(joints) else joints

    def _escapes(self, violation: GuardViolation, pose: Pose, joints: Joints) -> Iterator[Pose]:
        """Yield the poses that leave one guard by each of its bounds."""
        guards, direction = self.guarded.guards, self._direction()
        if violation.guard == "table":
            yield replace(pose, z_mm=pose.z_mm + violation.excess_mm)
        elif violation.guard == "outer radius" and guards.outer_radius_mm is not None:
            yield at_radius(pose, guards.outer_radius_mm, direction)
        elif violation.guard == "inner radius" and guards.inner_radius_mm is not None:
            yield at_radius(pose, guards.inner_radius_mm, direction)
            yield replace(pose, z_mm=guards.inner_height_mm)
        elif violation.guard == "hand against base":
            yield at_radius(pose, guards.hand_tip_radius_mm, direction)
            yield replace(pose, z_mm=guards.hand_height_mm)
            yield at_radius(pose, math.hypot(pose.x_mm, pose.y_mm) + violation.excess_mm, direction)
        elif violation.guard.startswith(BOX):
            yield from out_of_box(self.guarded, violation, pose, joints)
        else:
            yield from steepest(self.guarded, violation, pose, joints)

    def _direction(self) -> float:
        """Return the pose's direction from the base axis, or the seed's for a pose on the axis."""
        if math.hypot(self.pose.x_mm, self.pose.y_mm) > AXIS_MM:
            return math.atan2(self.pose.y_mm, self.pose.x_mm)
        return self.arm.limits[0].clamp(self.seed[0] if self.seed else 0.0)


def _new(pose: Pose, seen: set[Pose]) -> bool:
    """Return whether a pose is new, to a thousandth of a mm, and remember it."""
    rounded = replace(
        pose, x_mm=round(pose.x_mm, 3), y_mm=round(pose.y_mm, 3), z_mm=round(pose.z_mm, 3)
    )
    if rounded in seen:
        return False
    seen.add(rounded)
    return True


def _between(start: Pose, end: Pose, share: float) -> Pose:
    """Return the pose at a share of the path in x, y, z and, the shorter way round, the angles."""
    ends = zip(start.position_mm, end.position_mm, strict=True)
    x, y, z = (a + share * (b - a) for a, b in ends)
    yaw = None
    if start.yaw_rad is not None and end.yaw_rad is not None:
        yaw = _turned(start.yaw_rad, end.yaw_rad, share)
    pitch = _turned(start.pitch_rad, end.pitch_rad, share)
    return Pose(x, y, z, pitch, _turned(start.roll_rad, end.roll_rad, share), yaw)


def _turned(start_rad: float, end_rad: float, share: float) -> float:
    return start_rad + share * math.remainder(end_rad - start_rad, math.tau)
