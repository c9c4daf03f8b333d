"""The path of a jog, how far it may go, and which limit or guard ends it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.motion.frames import axes_of
from armdrive.motion.plan import SpeedLimits, guard_error
from armdrive.moves import BASE_FRAME, CARTESIAN_AXES, GRIPPER_AXIS, YAW_AXIS, Space
from armdrive.runtime.position import ArmCoordinates
from kinematics.errors import KinematicsError
from kinematics.geometry import Unreachable
from kinematics.guards import GuardViolation
from kinematics.guards.path import first_violation
from kinematics.paths.curves import LEAP_RAD, largest_turn
from kinematics.spaces import Joints, Pose

HALVINGS = 9  # bisection steps: a bound is found to 1/512 of the distance ahead
REACH_HALVINGS = 16  # at the edge of the reach, the last steps of a joint move the tip by microns

# A speed for each axis, the gripper last: in rad/s and mm/s, or as shares of full speed.
Rates = tuple[float, ...]

Span = tuple[float, float]

# The space and the frame of a jog.
Kind = tuple[Space, str]

# The axes of a jog: their names, their full speeds and their ranges.

# Full speed of pitch, roll and yaw in a Cartesian jog, before joint limits slow it.
ANGULAR_JOG_RAD_S = math.radians(45.0)

UNBOUNDED: Span = (-math.inf, math.inf)


def axis_names(config: ArmConfig, space: Space) -> tuple[str, ...]:
    """Return the axes of a jog in a space, the gripper last."""
    if space is Space.JOINT:
        return (*config.model.arm.joint_names, GRIPPER_AXIS)
    yaw = (YAW_AXIS,) if config.model.arm.has_yaw else ()
    return (*CARTESIAN_AXES, *yaw, GRIPPER_AXIS)


def full_speeds(config: ArmConfig, speeds: SpeedLimits, space: Space) -> Rates:
    """Return the full speed of each axis, in rad/s and mm/s."""
    if space is Space.JOINT:
        return (*speeds.joints_rad_s, speeds.gripper_mm_s)
    turns = (ANGULAR_JOG_RAD_S,) * (3 if config.model.arm.has_yaw else 2)
    return (*(config.motion.tip_speed_mm_s,) * 3, *turns, speeds.gripper_mm_s)


def spans_of(config: ArmConfig, start: ArmCoordinates) -> tuple[Span, ...]:
    """Return the allowed range of each joint, followed by the gripper: moving back is allowed."""
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    ranges = zip((*bounds, config.model.gripper_range_mm), start.values, strict=True)
    return tuple((min(low, a), max(high, a)) for (low, high), a in ranges)


def ways_left(config: ArmConfig, space: Space, start: ArmCoordinates) -> tuple[Span, ...]:
    """Return how far each axis may go down and up. Only joints and fingers have ranges."""
    spans = zip(spans_of(config, start), start.values, strict=True)
    left = tuple((low - a, high - a) for (low, high), a in spans)
    if space is Space.JOINT:
        return left
    return (*(UNBOUNDED for _ in axis_names(config, space)[1:]), left[-1])


def at_limits(names: Sequence[str]) -> str:
    """Return a note about the axes that have stopped at their limits, or an empty string."""
    return f"the {' and the '.join(names)} stopped at the limit" if names else ""


# The path: the point after a time at given rates, in joint space or along the tip's line.

HOP_S = 0.1  # a posture farther ahead is solved in hops of this length, each from the previous one
FURTHER_S = (0.0, 0.02, 0.1)  # how far beyond the end of a line its reason is searched for

ELSEWHERE = "the arm would have to change its posture abruptly"


class JogPath:
    """The path of a jog from an unrounded point, at rates in rad/s and mm/s.

    In joint space, each joint goes up to its limit. In Cartesian space, the path is straight in x,
    y, z, pitch, roll and yaw, and the tip's rates are those of the jog's frame. Without `bounded`,
    joints have no limits; the fingers of a Cartesian jog always have theirs. Speed limits are not
    considered here.
    """

    def __init__(
        self,
        config: ArmConfig,
        kind: Kind,
        start: ArmCoordinates,
        rates: Rates,
        *,
        bounded: bool = True,
    ) -> None:
        """Raises `BadRequest` for an unknown frame."""
        space, frame = kind
        cartesian = space is Space.CARTESIAN
        self._arm = config.model.arm
        self._start = on_limits(config, start) if cartesian else start
        self._rates = _in_base(config, frame, start, rates) if cartesian else rates
        self._pose = self._arm.fk(self._start.joints) if cartesian else None
        unbounded = (UNBOUNDED,) * len(start.values)
        self._spans = spans_of(config, start) if bounded or cartesian else unbounded
        self._solved: list[tuple[float, Joints]] = [(0.0, self._start.joints)]

    def at(self, time_s: float) -> ArmCoordinates | None:
        """Return the point after a time; None if no posture within the limits reaches it."""
        *joint_spans, (low_mm, high_mm) = self._spans
        opening_mm = self._start.opening_mm + self._rates[-1] * time_s
        opening_mm = min(max(opening_mm, low_mm), high_mm)
        here: Joints | None = self._start.joints
        if self._pose is None:
            turns = zip(self._start.joints, self._rates, joint_spans, strict=False)
            angles = (min(max(a + b * time_s, low), high) for a, b, (low, high) in turns)
            here = Joints(tuple(angles), self._start.joints.names)
        elif any(self._rates[:-1]):
            here = self._solve(time_s)
        return None if here is None else ArmCoordinates(here, opening_mm)

    def why(self, time_s: float) -> KinematicsError | str:
        """Return why there is no point after a time."""
        _, before = self._before(time_s)
        # exactly at the edge, one solver may still succeed where another fails
        for further_s in FURTHER_S:
            try:
                self._arm.ik_near(self._pose_at(time_s + further_s), before)
            except KinematicsError as refusal:
                return refusal
        return ELSEWHERE

    def _pose_at(self, time_s: float) -> Pose:
        """Return the pose on the line after a time, reachable or not."""
        pose = self._pose or self._arm.fk(self._start.joints)
        x, y, z, pitch, roll, *yaw, _ = self._rates
        return Pose(
            pose.x_mm + x * time_s,
            pose.y_mm + y * time_s,
            pose.z_mm + z * time_s,
            pose.pitch_rad + pitch * time_s,
            pose.roll_rad + roll * time_s,
            None if pose.yaw_rad is None else pose.yaw_rad + math.fsum(yaw) * time_s,
        )

    def _before(self, time_s: float) -> tuple[float, Joints]:
        """Return the latest solved moment up to this one, and its posture."""
        known = (one for one in self._solved if one[0] <= time_s)
        return max(known, key=lambda one: one[0])

    def _solve(self, time_s: float) -> Joints | None:
        at_s, before = self._before(time_s)
        hops = math.ceil((time_s - at_s) / HOP_S)  # 0 if this moment has been solved already
        for hop in range(1, hops + 1):
            next_s = time_s if hop == hops else at_s + hop * HOP_S
            joints = self._arm.solve_near(self._pose_at(next_s), before)
            if joints is None or largest_turn(before, joints)[1] > LEAP_RAD:
                return None
            self._solved.append((next_s, joints))
            before = joints
        return before


def _in_base(config: ArmConfig, frame: str, start: ArmCoordinates, rates: Rates) -> Rates:
    """Return a tip's rates with x, y and z converted from its frame to the base frame."""
    if frame == BASE_FRAME:
        return rates
    x, y, z, *others = rates
    axes = axes_of(config, start.joints, frame)
    turned = (x * a + y * b + z * c for a, b, c in zip(*axes, strict=True))
    return (*turned, *others)


def on_limits(config: ArmConfig, start: ArmCoordinates) -> ArmCoordinates:
    """Move a point that lies beyond a limit only by rounding to steps back to the limit.

    Otherwise no line of the tip could start where a joint jog has ended.
    """
    if not config.model.arm.violations(start.joints):
        return start
    angles = []
    rows = zip(config.model.arm.limits, config.transmission.inverse, start.joints, strict=False)
    for bounds, row, angle in rows:
        near = bounds.clamp(angle)
        step_rad = math.fsum(map(abs, row))
        angles.append(near if abs(near - angle) <= step_rad else angle)
    return ArmCoordinates(Joints(tuple(angles), start.joints.names), start.opening_mm)


# The bounds of a path besides the limits of joints: its reach and the guards.


@dataclass(frozen=True, slots=True)
class JogEnded:
    """Why a jog goes no further; `cause` is the error with its code, if there is one."""

    note: str
    cause: Exception | None = None


@dataclass(frozen=True, slots=True)
class Free:
    """How long a jog can continue at its speed, within reach and clear of all guards.

    `beyond_s` is a moment at which the bound has been passed; infinite without one. `guarded`: the
    bound is a guard.
    """

    free_s: float
    beyond_s: float = math.inf
    guarded: bool = False


class Bounds:
    """The reach and the guards of one arm."""

    def __init__(self, config: ArmConfig) -> None:
        self._arm = config.model.arm
        self._guards = config.model.guards

    def free(self, way: JogPath, here: Joints, look_s: float, from_s: float = 0.0) -> Free:
        """Return how long a path is free, at most `look_s`; it passes `here` at `from_s`."""

        def reached(time_s: float) -> bool:
            return way.at(from_s + time_s) is not None

        def clear(time_s: float) -> bool:
            there = way.at(from_s + time_s)
            return there is not None and self.holds(here, there.joints)

        reach_s, unreached_s = furthest(reached, look_s, REACH_HALVINGS)
        clear_s, unclear_s = furthest(clear, reach_s)
        return Free(clear_s, min(unreached_s, unclear_s), guarded=clear_s < reach_s)

    def holds(self, here: Joints, there: Joints) -> bool:
        """Return whether the straight path in joint space violates no guard more deeply."""
        return self._broken(here, there) is None

    def ended(self, way: JogPath, here: Joints, beyond_s: float) -> JogEnded:
        """Return the reason why the path ends before a moment."""
        there = way.at(beyond_s)
        if there is None:
            why = way.why(beyond_s)
            cause = why if isinstance(why, Exception) else None
            return _ended(why.reason if isinstance(why, Unreachable) else str(why), cause)
        broken = self._broken(here, there.joints)
        if broken is None:  # joints or motors would have to turn without end
            return _ended(ELSEWHERE, None)
        return _ended(broken.sentence, guard_error(broken, 1.0))

    def _broken(self, here: Joints, there: Joints) -> GuardViolation | None:
        found = first_violation(self._arm, self._guards, [here, there])
        return None if found is None else found[1]


def _ended(words: str, cause: Exception | None) -> JogEnded:
    return JogEnded(f"the jog ended here: further on, {words}", cause)


def furthest(
    good: Callable[[float], bool], most: float, halvings: int = HALVINGS
) -> tuple[float, float]:
    """Return, by bisection, the largest good value up to `most`, and a larger one that is not good.

    The second is infinite if `most` is good. With `most` of 0, `good` is not called.
    """
    if most <= 0.0 or good(most):
        return most, math.inf
    low, high = 0.0, most
    for _ in range(halvings):
        middle = (low + high) / 2.0
        if good(middle):
            low = middle
        else:
            high = middle
    return low, high
