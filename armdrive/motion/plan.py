"""Planning: corner points in joint space, their audit, and the timed legs between them.

A leg is straight in joint space and has one speed. During acceleration and deceleration the legs
are short, so that their speeds follow the ramp (kinematics/paths/timing.py). Units: rad, mm, s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from armdrive.abilities import ramp_piece_s
from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest, OutOfBounds
from armdrive.registry import dialect
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from kinematics.errors import suggestion
from kinematics.geometry import ArmGeometry, Unreachable
from kinematics.guards import GuardViolation
from kinematics.guards.escape import nearest_allowed
from kinematics.guards.path import first_violation
from kinematics.limits import LimitViolation
from kinematics.paths.chords import line_path
from kinematics.paths.routes import LinePart, PathPart, PathSection, PosePart, Route, route_sections
from kinematics.paths.timing import MotionLimits, Point, timed
from kinematics.spaces import Joints, Pose
from kinematics.text import beyond, joint_text, mm_text
from kinematics.transmission import Transmission

SKIPPED_SHARE = 0.75  # share of the tolerance for skipped corners; the rest covers the way between


@dataclass(frozen=True, slots=True)
class SpeedLimits:
    """The speed limits for timing: joints in rad/s, gripper in mm/s, motors in Hz.

    A joint reaches full speed in `ramp_s` (0: at once), or with its own acceleration in
    `accelerations_rad_s2`; the acceleration builds up in `jerk_s`. `limits` holds the same values
    by coordinate: the joints, followed by the opening if a motor drives it.
    """

    joints_rad_s: tuple[float, ...]
    gripper_mm_s: float
    motor_hz: float
    transmission: Transmission
    ramp_s: float = 0.0
    jerk_s: float = 0.0
    accelerations_rad_s2: tuple[float | None, ...] = ()
    limits: MotionLimits = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "limits", self._limits())

    def duration_s(self, start: ArmCoordinates, end: ArmCoordinates, fraction: float) -> float:
        """Return the least time in which no joint and no motor exceeds its limit."""
        gripper = self.transmission.has_gripper
        ends = zip(_point(start, gripper), _point(end, gripper), strict=True)
        return self.limits.least_s([b - a for a, b in ends]) / fraction

    def _limits(self) -> MotionLimits:
        own = self.accelerations_rad_s2 or (None,) * len(self.joints_rad_s)
        speeds = self.joints_rad_s
        if self.transmission.has_gripper:
            own, speeds = (*own, None), (*speeds, self.gripper_mm_s)
        usual = [speed / self.ramp_s if self.ramp_s > 0.0 else math.inf for speed in speeds]
        return MotionLimits(
            speeds,
            tuple(one if one is not None else other for one, other in zip(own, usual, strict=True)),
            self.jerk_s,
            self.transmission.matrix,
            self.motor_hz,
        )


def legs_along(
    speeds: SpeedLimits, corners: Sequence[ArmCoordinates], fraction: float, longest_s: float
) -> tuple[MotionSegment, ...]:
    """Return the legs of a path that starts and ends at rest and has no stop in between.

    While the speed changes, legs last at most `longest_s`.
    """
    gripper = speeds.transmission.has_gripper
    path = timed([_point(corner, gripper) for corner in corners], speeds.limits, fraction)
    places = {_point(corner, gripper): corner for corner in corners}
    return tuple(_legs(corners[0], path.pieces(longest_s), places))


def _legs(
    start: ArmCoordinates,
    pieces: Sequence[tuple[Point, float]],
    places: dict[Point, ArmCoordinates],
) -> Iterator[MotionSegment]:
    for point, duration_s in pieces:
        end = places.get(point) or _between(start, point)
        yield MotionSegment(start, end, duration_s)
        start = end


def _point(place: ArmCoordinates, gripper: bool) -> Point:
    return (*place.joints, place.opening_mm) if gripper else place.joints.angles_rad


def _between(start: ArmCoordinates, point: Point) -> ArmCoordinates:
    count = len(start.joints)
    opening_mm = point[count] if len(point) > count else start.opening_mm
    return ArmCoordinates(Joints(point[:count], start.joints.names), opening_mm)


def fewer(
    arm: ArmGeometry, legs: Sequence[MotionSegment], longest_s: float, tolerance_mm: float
) -> tuple[MotionSegment, ...]:
    """Join legs that a single burst can drive within the tolerance.

    A corner may be skipped if the tip passes it, at the same time, within the tolerance.
    """
    found: list[MotionSegment] = []
    waiting: list[MotionSegment] = []
    for leg in legs:
        if waiting and not _one(arm, [*waiting, leg], longest_s, tolerance_mm):
            found.append(_joined(waiting))
            waiting = []
        waiting.append(leg)
    return (*found, _joined(waiting)) if waiting else ()


def _joined(legs: Sequence[MotionSegment]) -> MotionSegment:
    if len(legs) == 1:
        return legs[0]
    return MotionSegment(legs[0].start, legs[-1].end, math.fsum(leg.duration_s for leg in legs))


def _one(
    arm: ArmGeometry, legs: Sequence[MotionSegment], longest_s: float, tolerance_mm: float
) -> bool:
    """Return whether one burst may replace these legs."""
    whole = _joined(legs)
    if whole.duration_s > longest_s:
        return False
    passed_s = 0.0
    for leg in legs[:-1]:
        passed_s += leg.duration_s
        way = whole.start.towards(whole.end, passed_s / whole.duration_s)
        there, meant = arm.points(way.joints)[-1], arm.points(leg.end.joints)[-1]
        if math.dist(there, meant) > tolerance_mm * SKIPPED_SHARE:
            return False
    return True


# A whole plan is audited before its first byte is sent: every joint limit at every corner (a leg is
# straight in joint space, so its worst points are its ends) and every guard along the way
# (kinematics/guards/path.py). If the start is beyond a bound, the plan is allowed as long as it
# never goes farther beyond: there must be a way out.

OPTIONS = ("speed", "wait")  # keywords to suggest for a misspelt joint name

NEARLY = 0.999  # a blend of at least this share of the requested radius needs no note


@dataclass(frozen=True, slots=True)
class MotionPlan:
    """The legs of a motion, end to end and not yet rounded to steps."""

    start: ArmCoordinates
    legs: tuple[MotionSegment, ...]
    note: str = ""

    @property
    def end(self) -> ArmCoordinates:
        """The end point of the plan."""
        return self.legs[-1].end if self.legs else self.start

    @property
    def duration_s(self) -> float:
        """The duration, without the time for exchanges between bursts."""
        return math.fsum(leg.duration_s for leg in self.legs)


def named_joints(start: Joints, named_deg: Mapping[str, float]) -> Joints:
    """Return `start` with some joints replaced, given as `shoulder_deg=40`."""
    known = [f"{name}_deg" for name in start.names]
    for word in named_deg:
        if word not in known:
            hint = suggestion(word, (*known, *OPTIONS))
            raise BadRequest(f"no joint is called {word!r}; known are {', '.join(known)}{hint}")
    return start.replace(**named_deg)


def plan_joints(
    config: ArmConfig,
    speeds: SpeedLimits,
    start: ArmCoordinates,
    end: ArmCoordinates,
    fraction: float,
) -> MotionPlan:
    """Plan a motion straight in joint space, and audit it."""
    return _plan(config, speeds, start, [[start, end]], fraction)


def plan_line(
    config: ArmConfig, speeds: SpeedLimits, start: ArmCoordinates, goal: Pose, fraction: float
) -> MotionPlan:
    """Plan a motion straight in x, y, z, pitch and roll, in one posture, and audit it.

    Between corners the tip leaves the line by at most `motion.line_tolerance_mm`.
    """
    posture_for(config, goal, start.joints)
    joints = line_path(
        config.model.arm, start.joints, goal, tolerance_mm=config.motion.line_tolerance_mm
    )
    corners = [start, *(ArmCoordinates(each, start.opening_mm) for each in joints[1:])]
    return _plan(config, speeds, start, [corners], fraction)


def plan_route(
    config: ArmConfig,
    speeds: SpeedLimits,
    start: ArmCoordinates,
    moves: Sequence[PathPart],
    fraction: float,
) -> MotionPlan:
    """Plan a sequence of joint motions, lines and arcs with blends, and audit all of it."""
    for move in moves:
        if isinstance(move, LinePart | PosePart):
            posture_for(config, move.goal, start.joints)
    route = Route(start.joints, tuple(moves))
    sections = route_sections(config.model.arm, route, tolerance_mm=config.motion.line_tolerance_mm)
    ways = [
        [ArmCoordinates(each, start.opening_mm) for each in section.corners] for section in sections
    ]
    made = _plan(config, speeds, start, ways, fraction)
    return replace(made, note=_smaller_blends(moves, sections))


def _smaller_blends(moves: Sequence[PathPart], sections: Sequence[PathSection]) -> str:
    """Return a note about the blends that are smaller than requested. The last part has none."""
    found = {
        part: radius_mm
        for section in sections
        for part, radius_mm in zip(section.parts, section.blends_mm, strict=True)
    }
    said = [
        f"the blend after part {part} is {mm_text(found.get(part, 0.0))} instead of "
        f"{mm_text(move.blend_mm)}, because a neighbouring part is too short"
        for part, move in enumerate(moves[:-1], 1)
        if found.get(part, 0.0) < move.blend_mm * NEARLY
    ]
    return "; ".join(said)


def _plan(
    config: ArmConfig,
    speeds: SpeedLimits,
    start: ArmCoordinates,
    ways: list[list[ArmCoordinates]],
    fraction: float,
) -> MotionPlan:
    """Audit the corners of paths that each end at rest, and time them."""
    audit(config, [start.joints, *(corner.joints for way in ways for corner in way)])
    end_mm = ways[-1][-1].opening_mm if ways else start.opening_mm
    if end_mm != start.opening_mm:
        audit_opening(config, end_mm)
    motion, connection = config.motion, config.connection
    able = dialect(connection.dialect).abilities
    longest_s = joined_s = motion.planned_burst_s
    if able.queued_segments:
        joined_s = able.traffic.shortest_segment_s(connection.baud)
        longest_s = ramp_piece_s(longest_s, joined_s)
    legs: list[MotionSegment] = []
    for way in ways:
        moving = [a for a, b in pairwise(way) if a != b]
        made = legs_along(speeds, [*moving, way[-1]], fraction, longest_s) if moving else ()
        legs += fewer(config.model.arm, made, joined_s, motion.line_tolerance_mm)
    return MotionPlan(start, tuple(legs))


SLACK_RAD = 1e-9  # a joint beyond its limit whose excess grows by rounding alone goes no further


def audit(config: ArmConfig, corners: list[Joints]) -> None:
    """Raise `OutOfBounds` for the first limit or guard that a joint path would violate."""
    arm = config.model.arm
    excused = {each.joint: each.excess for each in arm.violations(corners[0])}
    for corner in corners[1:]:
        for violation in arm.violations(corner):
            if violation.excess > excused.get(violation.joint, 0.0) + SLACK_RAD:
                raise limit_error(violation)
    found = first_violation(arm, config.model.guards, corners)
    if found is not None:
        raise guard_error(found[1], found[0])


def posture_for(config: ArmConfig, goal: Pose, seed: Joints) -> Joints:
    """Return the allowed posture for a pose that is nearest to the seed.

    Raises `Unreachable` or `OutOfBounds`; both name a nearest pose that a joint motion reaches.
    """
    arm, guards = config.model.arm, config.model.guards
    try:
        joints = arm.ik(goal, seed)
    except Unreachable as refusal:
        raise refusal.instead(nearest_goal(config, goal, seed)) from None
    broken = guards.violation(arm, joints)
    if broken is None or guards.violations(arm, seed):
        return joints  # a start inside a guard may have a way out: the audit checks the whole path
    raise guard_error(broken, 1.0, nearest_goal(config, goal, seed))


# How far beyond the bound a pose is moved until it is allowed as messages print it.
FURTHER_MM = (0.0, 0.1, 0.3, 1.0, 3.0)


def nearest_goal(config: ArmConfig, goal: Pose, seed: Joints) -> Pose | None:
    """Return the nearest allowed pose; None if no joint motion leads there from the seed.

    If possible, it is rounded as messages print it, so that a person can type what they read.
    """
    arm = config.model.arm
    exact = nearest_allowed(arm, config.model.guards, goal, seed)
    if exact is None or not _leads_to(config, seed, exact):
        return None
    away_mm = math.dist(goal.position_mm, exact.position_mm) or 1.0
    ends = tuple(zip(goal.position_mm, exact.position_mm, strict=True))
    for further_mm in FURTHER_MM:
        x, y, z = (round(b + (b - a) * further_mm / away_mm, 1) for a, b in ends)
        pose = replace(_printed(exact, goal), x_mm=x, y_mm=y, z_mm=z)
        if _leads_to(config, seed, pose):
            return pose
    return exact


def _printed(pose: Pose, goal: Pose) -> Pose:
    """Return a pose with its angles as messages print them; those of the goal stay exact."""
    angles = {
        name: math.radians(round(math.degrees(angle), 1))
        for name in ("pitch_rad", "roll_rad", "yaw_rad")
        if (angle := getattr(pose, name)) is not None and angle != getattr(goal, name)
    }
    return replace(pose, **angles)


def _leads_to(config: ArmConfig, seed: Joints, pose: Pose) -> bool:
    """Return whether a joint motion leads from the seed to a pose."""
    joints = config.model.arm.solve(pose, seed)
    if joints is None:
        return False
    try:
        audit(config, [seed, joints])
    except OutOfBounds:
        return False
    return True


def limit_error(violation: LimitViolation) -> OutOfBounds:
    """Return the error of a violated joint limit."""
    value_rad, bound_rad = violation.value, violation.bound
    return OutOfBounds(
        f"the {violation.joint} would turn to {joint_text(value_rad, 'rad')}, "
        f"{beyond(value_rad, bound_rad)}; nothing was moved",
        name=violation.joint,
        value=math.degrees(value_rad),
        bound=math.degrees(bound_rad),
    )


def guard_error(guard: GuardViolation, share: float, nearest: Pose | None = None) -> OutOfBounds:
    """Return the error of a violated guard; its values are in mm, or degrees for joint sums."""
    where = "at the goal" if share >= 1.0 else f"{share:.0%} of the way to the goal"
    instead = f"; nearest pose that is allowed: {nearest}" if nearest is not None else ""
    value, bound = guard.value, guard.bound
    if guard.unit == "rad":
        value, bound = math.degrees(value), math.degrees(bound)
    return OutOfBounds(
        f"{guard.sentence}, {where}; nothing was moved{instead}",
        name=guard.guard,
        value=value,
        bound=bound,
        nearest=nearest,
    )


def audit_opening(config: ArmConfig, opening_mm: float) -> None:
    """Raise `OutOfBounds` for an opening that the gripper cannot reach."""
    low, high = config.model.gripper_range_mm
    if not low <= opening_mm <= high:
        raise OutOfBounds(
            f"the gripper opens from {low:g} to {high:g} mm, not to {opening_mm:g} mm",
            name="gripper",
            value=opening_mm,
            bound=high if opening_mm > high else low,
        )
