"""The bounds of a jog: how far it may go, and which limit or guard ends it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from armdrive.config.arm import ArmConfig
from armdrive.motion.frames import axes_of
from armdrive.motion.plan import guard_error
from armdrive.moves import BASE_FRAME, Space
from armdrive.runtime.position import ArmCoordinates
from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry, Unreachable
from kinematics.guards import GuardViolation
from kinematics.guards.path import first_violation
from kinematics.paths.curves import LEAP_RAD, largest_turn
from kinematics.spaces import Joints, Pose
from kinematics.transmission import Transmission

HALVINGS = 9  # bisection steps: a bound is found to 1/512 of the distance ahead


@dataclass(frozen=True, slots=True)
class JogEnded:
    """Why a jog goes no further; `cause` is the error with its code, if there is one."""

    note: str
    cause: Exception | None = None


@dataclass(frozen=True, slots=True)
class Free:
    """How long a jog can continue at its speed, within reach and clear of all guards.

    `beyond_s` is a moment at which the nearer bound has been passed; infinite without one.
    """

    reach_s: float
    clear_s: float
    beyond_s: float = math.inf

    @property
    def free_s(self) -> float:
        """How long the jog can continue within both bounds."""
        return min(self.reach_s, self.clear_s)


class Bounds:
    """The bounds of one arm's jogs besides joint limits: its reach and its guards.

    The clearance to the guards is computed once and then used up leg by leg. Only if it is not
    enough, the path itself is checked (kinematics/guards/path.py).
    """

    def __init__(self, config: ArmConfig, transmission: Transmission) -> None:
        self._arm = config.model.arm
        self._guards = config.model.guards
        self._transmission = transmission
        self._guarded = self._guards.over(self._arm)
        self._rounding_mm = self._most_rounding_mm()
        self._stands: Joints | None = None
        self._left_mm = 0.0
        self._looked = False

    def free(self, way: JogPath, here: Joints, look_s: float, from_s: float = 0.0) -> Free:
        """Return how long a path is free, at most `look_s`; it passes `here` at `from_s`."""
        reach_s, unreached_s = furthest(lambda time_s: way.at(from_s + time_s) is not None, look_s)

        def clear(time_s: float) -> bool:
            there = way.at(from_s + time_s)
            return there is not None and self.holds(here, there.joints)

        clear_s, unclear_s = furthest(clear, reach_s)
        return Free(reach_s, clear_s, min(unreached_s, unclear_s))

    def ended(self, way: JogPath, here: Joints, beyond_s: float) -> JogEnded:
        """Return the reason why the path ends before a moment."""
        there = way.at(beyond_s)
        if there is None:
            why = way.why(beyond_s)
            cause = why if isinstance(why, Exception) else None
            return _ended(why.reason if isinstance(why, Unreachable) else str(why), cause)
        broken = self._broken(here, there.joints)
        if broken is None:  # only rounding can cause this
            return JogEnded("")
        return _ended(broken.sentence, guard_error(broken, 1.0))

    def went(self, here: Joints, there: Joints) -> None:
        """Take into account that the arm moves, which uses up some of the clearance."""
        # the clearance that is left is known for this very posture, and for no other
        if self._stands is here:
            self._left_mm -= self._way_mm(here, there)
            self._stands, self._looked = there, False

    def holds(self, here: Joints, there: Joints) -> bool:
        """Return whether the straight path in joint space violates no guard, or none more deeply.

        Near a guard, the whole steps at which the arm would come to rest are checked as well.
        """
        way_mm = self._way_mm(here, there) + self._rounding_mm
        if not self._guards.sums and self._has_room(here, way_mm):
            return True
        return self._broken(here, there) is None

    def _broken(self, here: Joints, there: Joints) -> GuardViolation | None:
        for way in ([here, there], [self._whole(here), self._whole(there)]):
            found = first_violation(self._arm, self._guards, way)
            if found is not None:
                return found[1]
        return None

    def _whole(self, joints: Joints) -> Joints:
        """Return a posture rounded to whole steps."""
        return self._transmission.to_joints(self._transmission.to_motors(joints))[0]

    def _has_room(self, here: Joints, way_mm: float) -> bool:
        known = self._stands is here
        if known and way_mm <= self._left_mm:
            return True
        if not (known and self._looked):
            self._stands, self._looked = here, True
            self._left_mm = self._guarded.room_mm(here)
        return way_mm <= self._left_mm

    def _most_rounding_mm(self) -> float:
        """Return how far rounding to whole steps moves any point of the arm at most."""
        rows = self._transmission.inverse[: len(self._arm.limits)]
        return self._arm.travel_bound_mm([0.5 * math.fsum(map(abs, row)) for row in rows])

    def _way_mm(self, here: Joints, there: Joints) -> float:
        return self._arm.travel_bound_mm([b - a for a, b in zip(here, there, strict=True)])


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


def at_limits(names: Sequence[str]) -> str:
    """Return a note about the axes that have stopped at their limits, or an empty string."""
    return f"the {' and the '.join(names)} stopped at the limit" if names else ""


def _ended(words: str, cause: Exception | None) -> JogEnded:
    return JogEnded(f"the jog ended here: further on, {words}", cause)


# The path of a jog: the point after a time at given rates, in joint space or along the tip's line.
#
# Rates are in rad/s and mm/s. A path starts at an unrounded point and is straight in joint space,
# or straight in x, y, z, pitch, roll and yaw. Speed limits are not considered here.

HOP_S = 0.1  # a posture farther ahead is solved in hops of this length, each from the previous one
FURTHER_S = (0.0, 0.02, 0.1)  # how far beyond the end of a line its reason is searched for

ELSEWHERE = "the arm would have to change its posture abruptly"

Span = tuple[float, float]

Kind = tuple[Space, str]
"""The space and the frame of a jog."""


class JogPath(Protocol):
    """The path of a jog."""

    def at(self, time_s: float) -> ArmCoordinates | None:
        """Return the point after a time; None if no posture within the limits reaches it."""

    def why(self, time_s: float) -> KinematicsError | str:
        """Return why there is no point after a time."""


@dataclass(frozen=True, slots=True, eq=False)
class JointJogPath:
    """Joints and gripper move at given rates, each up to its limit in `spans`, if given."""

    start: ArmCoordinates
    rates: Sequence[float]
    spans: Sequence[Span] | None = None

    def at(self, time_s: float) -> ArmCoordinates:
        """Return the point after a time."""
        there = [a + rate * time_s for a, rate in zip(self.start.values, self.rates, strict=True)]
        if self.spans is not None:
            bounded = zip(there, self.spans, strict=True)
            there = [min(max(a, low), high) for a, (low, high) in bounded]
        *angles, opening_mm = there
        return ArmCoordinates(Joints(tuple(angles), self.start.joints.names), opening_mm)

    def why(self, time_s: float) -> KinematicsError | str:  # noqa: ARG002
        """Return an empty string: there is always a point."""
        return ""


class TipJogPath:
    """The tip moves along a straight line, and the fingers within `span_mm`."""

    def __init__(
        self, config: ArmConfig, start: ArmCoordinates, rates: Sequence[float], span_mm: Span
    ) -> None:
        self._arm: ArmGeometry = config.model.arm
        self._start = start
        self._rates = rates
        self._span_mm = span_mm
        self._pose = self._arm.fk(start.joints)
        self._solved: list[tuple[float, Joints]] = [(0.0, start.joints)]

    def at(self, time_s: float) -> ArmCoordinates | None:
        """Return the point after a time; None if no posture within the limits reaches it."""
        low, high = self._span_mm
        opening_mm = min(max(self._start.opening_mm + self._rates[-1] * time_s, low), high)
        if not any(self._rates[:-1]):
            return ArmCoordinates(self._start.joints, opening_mm)
        joints = self._joints(time_s)
        return None if joints is None else ArmCoordinates(joints, opening_mm)

    def why(self, time_s: float) -> KinematicsError | str:
        """Return why there is no point after a time."""
        _, before = self._before(time_s)
        # exactly at the edge, one solver may still succeed where another fails
        for further_s in FURTHER_S:
            try:
                self._arm.ik_near(self.pose(time_s + further_s), before)
            except KinematicsError as refusal:
                return refusal
        return ELSEWHERE

    def pose(self, time_s: float) -> Pose:
        """Return the pose on the line after a time, reachable or not."""
        pose, (x, y, z, pitch, roll, *yaw, _) = self._pose, self._rates
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

    def _joints(self, time_s: float) -> Joints | None:
        at_s, before = self._before(time_s)
        if time_s and at_s == time_s:
            return before
        hops = max(math.ceil((time_s - at_s) / HOP_S), 1)
        for hop in range(1, hops + 1):
            next_s = time_s if hop == hops else at_s + hop * HOP_S
            joints = self._arm.solve_near(self.pose(next_s), before)
            if joints is None:
                return None
            if largest_turn(before, joints)[1] > LEAP_RAD:
                return None
            self._solved.append((next_s, joints))
            before = joints
        return before


def jog_path(
    config: ArmConfig,
    kind: Kind,
    start: ArmCoordinates,
    rates: Sequence[float],
    spans: Sequence[Span] | None = None,
) -> JogPath:
    """Return the path of a jog. Without `spans` the joints are unbounded; the fingers never are."""
    if kind[0] is Space.JOINT:
        return JointJogPath(start, rates, spans)
    rates = in_base(config, kind, start, rates)
    return TipJogPath(config, on_limits(config, start), rates, spans_of(config, start)[-1])


def in_base(
    config: ArmConfig, kind: Kind, start: ArmCoordinates, rates: Sequence[float]
) -> tuple[float, ...]:
    """Return a tip's rates with x, y and z converted from its frame to the base frame."""
    _, frame = kind
    if frame == BASE_FRAME:
        return tuple(rates)
    x, y, z, *others = rates
    axes = axes_of(config, start.joints, frame)
    turned = (x * a + y * b + z * c for a, b, c in zip(*axes, strict=True))
    return (*turned, *others)


def spans_of(config: ArmConfig, start: ArmCoordinates) -> tuple[Span, ...]:
    """Return the allowed range of each joint, followed by the gripper: moving back is allowed."""
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    ranges = zip((*bounds, config.model.gripper_range_mm), start.values, strict=True)
    return tuple((min(low, a), max(high, a)) for (low, high), a in ranges)


def on_limits(config: ArmConfig, start: ArmCoordinates) -> ArmCoordinates:
    """Move a point that lies beyond a limit only by rounding to steps back to the limit.

    Otherwise no line of the tip could start where a joint jog has ended.
    """
    transmission = config.model.transmission
    if transmission is None or not config.model.arm.violations(start.joints):
        return start
    angles = []
    rows = zip(config.model.arm.limits, transmission.inverse, start.joints, strict=False)
    for bounds, row, angle in rows:
        near = bounds.clamp(angle)
        step_rad = math.fsum(map(abs, row))
        angles.append(near if abs(near - angle) <= step_rad else angle)
    return ArmCoordinates(Joints(tuple(angles), start.joints.names), start.opening_mm)
