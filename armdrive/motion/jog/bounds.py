"""How far a jog may go on its way before a bound, and what bound that is, in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from armdrive.config.arm import ArmConfig
from armdrive.motion.frames import BASE, axes_of
from armdrive.motion.plan import guard_error
from armdrive.moves import Space
from armdrive.runtime.position import ArmCoordinates
from kinematics.errors import KinematicsError, Unreachable
from kinematics.geometry import ArmGeometry
from kinematics.guards.guards import Violation
from kinematics.guards.path import first_violation
from kinematics.spaces import Joints, Pose
from kinematics.transmission import Transmission

HALVINGS = 9
"""How closely a bound is looked for: to a five-hundredth of what is looked ahead, leg by leg."""


@dataclass(frozen=True, slots=True)
class JogEnded:
    """Why a jog goes no further; `cause` gives the code of it in the catalogue, if it has one."""

    note: str
    cause: Exception | None = None


@dataclass(frozen=True, slots=True)
class Free:
    """How long a way is free at its speed: of the edge of the reach, and of the guards.

    `beyond_s` is a moment at which the nearer of the two is passed; none where all is free.
    """

    reach_s: float
    clear_s: float
    beyond_s: float = math.inf

    @property
    def free_s(self) -> float:
        """How long it is free of both."""
        return min(self.reach_s, self.clear_s)


class Bounds:
    """What bounds the jogs of one arm besides its limits: its reach and its guards.

    How far the arm may travel before a guard is broken is looked at once and then used up leg by
    leg; only where that does not suffice is the way itself proved (kinematics/guards/path.py).
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
        """Return how long a way is free that is here at a moment of it, at most `look_s`."""
        reach_s, unreached_s = furthest(lambda time_s: way.at(from_s + time_s) is not None, look_s)

        def clear(time_s: float) -> bool:
            there = way.at(from_s + time_s)
            return there is not None and self.holds(here, there.joints)

        clear_s, unclear_s = furthest(clear, reach_s)
        return Free(reach_s, clear_s, min(unreached_s, unclear_s))

    def ended(self, way: JogPath, here: Joints, beyond_s: float) -> JogEnded:
        """Say what is passed at a moment."""
        there = way.at(beyond_s)
        if there is None:
            why = way.why(beyond_s)
            cause = why if isinstance(why, Exception) else None
            return _ended(why.reason if isinstance(why, Unreachable) else str(why), cause)
        broken = self._broken(here, there.joints)
        if broken is None:  # only rounding can bring this about
            return JogEnded("")
        return _ended(broken.sentence, guard_error(broken, 1.0))

    def went(self, here: Joints, there: Joints) -> None:
        """Hear that the arm goes there, which uses up some of the room."""
        if self._stands is here:
            self._left_mm -= self._way_mm(here, there)
            self._stands, self._looked = there, False

    def holds(self, here: Joints, there: Joints) -> bool:
        """Tell whether the way straight in joint space breaks no guard, or none deeper.

        Near a guard that holds as well for the whole steps on which the arm would come to rest.
        """
        way_mm = self._way_mm(here, there) + self._rounding_mm
        if not self._guards.sums and self._has_room(here, way_mm):
            return True
        return self._broken(here, there) is None

    def _broken(self, here: Joints, there: Joints) -> Violation | None:
        for way in ([here, there], [self._whole(here), self._whole(there)]):
            found = first_violation(self._arm, self._guards, way, way_out=True)
            if found is not None:
                return found[1]
        return None

    def _whole(self, joints: Joints) -> Joints:
        """Return the posture on whole steps that stands for another."""
        return self._transmission.to_joints(self._transmission.to_motors(joints))[0]

    def _has_room(self, here: Joints, way_mm: float) -> bool:
        known = self._stands is here
        if known and way_mm <= self._left_mm:
            return True
        if not (known and self._looked):
            self._stands, self._looked = here, True
            self._left_mm = min(self._guarded.room(here))
        return way_mm <= self._left_mm

    def _most_rounding_mm(self) -> float:
        """Return how far a point of the arm is off at most because motors stand on whole steps."""
        rows = self._transmission.inverse[: len(self._arm.limits)]
        return self._arm.travel_bound_mm([0.5 * math.fsum(map(abs, row)) for row in rows])

    def _way_mm(self, here: Joints, there: Joints) -> float:
        return self._arm.travel_bound_mm([b - a for a, b in zip(here, there, strict=True)])


def furthest(
    good: Callable[[float], bool], most: float, halvings: int = HALVINGS
) -> tuple[float, float]:
    """Return the furthest that is good, and something beyond it that is not; of 0 nothing is asked.

    The second is infinite where all is good.
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
    """Say which axes have stopped at the ends of their ranges, if any have."""
    return f"the {' and the '.join(names)} stopped at the limit" if names else ""


def _ended(words: str, cause: Exception | None) -> JogEnded:
    return JogEnded(f"the jog ended here: further on, {words}", cause)


# Where a jog leads: the point after a time at given rates, joint by joint or on the tip's line.
#
# Rates are rad/s and mm/s. A way leads from one unrounded point; it is straight in joint space or
# straight in x, y, z, pitch, roll and yaw. Nothing here asks how fast that may be.

HOP_S = 0.1
"""A posture so far ahead is not solved from the start, but from one on the way there."""

AT_ONCE_RAD = 0.5
"""A joint that turns further than this within a hop takes another posture."""

FURTHER_S = (0.0, 0.02, 0.1)
"""How much further than where a line ends its reason is looked for."""

ELSEWHERE = "the arm would have to take another posture at once"

Span = tuple[float, float]

Kind = tuple[Space, str]
"""What a jog is meant in: a space and a frame."""


class JogPath(Protocol):
    """What the course of a jog needs of a way."""

    def at(self, time_s: float) -> ArmCoordinates | None:
        """Return the point after a time, None where no posture within the limits reaches it."""

    def why(self, time_s: float) -> KinematicsError | str:
        """Say why there is no point after a time."""


@dataclass(frozen=True, slots=True, eq=False)
class JointJogPath:
    """Joints and gripper turn at rates, each until it meets its limit; none without `spans`."""

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
        """Say nothing: there always is a point."""
        return ""


class TipJogPath:
    """The tip goes straight on, and the fingers slide within `span_mm`."""

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
        """Return the point after a time, None where no posture within the limits reaches it."""
        low, high = self._span_mm
        opening_mm = min(max(self._start.opening_mm + self._rates[-1] * time_s, low), high)
        if not any(self._rates[:-1]):
            return ArmCoordinates(self._start.joints, opening_mm)
        joints = self._joints(time_s)
        return None if joints is None else ArmCoordinates(joints, opening_mm)

    def why(self, time_s: float) -> KinematicsError | str:
        """Say why there is no point after a time."""
        _, before = self._before(time_s)
        # at the very edge, one solver still finds what another does not
        for further_s in FURTHER_S:
            try:
                self._arm.ik_near(self.pose(time_s + further_s), before)
            except KinematicsError as refusal:
                return refusal
        return ELSEWHERE

    def pose(self, time_s: float) -> Pose:
        """Return the line's pose after a time, whether it can be reached or not."""
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
        """Return the last moment up to this one whose posture is known, and that posture."""
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
            if max(abs(b - a) for a, b in zip(before, joints, strict=True)) > AT_ONCE_RAD:
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
    """Return the way of a jog; joints know no bounds without `spans`, and the fingers always do."""
    if kind[0] is Space.JOINT:
        return JointJogPath(start, rates, spans)
    rates = in_base(config, kind, start, rates)
    return TipJogPath(config, on_limits(config, start), rates, spans_of(config, start)[-1])


def in_base(
    config: ArmConfig, kind: Kind, start: ArmCoordinates, rates: Sequence[float]
) -> tuple[float, ...]:
    """Return the rates of a tip with x, y and z of its frame turned into the base's."""
    _, frame = kind
    if frame == BASE:
        return tuple(rates)
    x, y, z, *others = rates
    axes = axes_of(config, start.joints, frame)
    turned = (x * a + y * b + z * c for a, b, c in zip(*axes, strict=True))
    return (*turned, *others)


def spans_of(config: ArmConfig, start: ArmCoordinates) -> tuple[Span, ...]:
    """Return where each joint, and then the gripper, may be: moving back is always allowed."""
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    ranges = zip((*bounds, config.model.gripper_range_mm), start.values, strict=True)
    return tuple((min(low, a), max(high, a)) for (low, high), a in ranges)


def on_limits(config: ArmConfig, start: ArmCoordinates) -> ArmCoordinates:
    """Return a point that rounding to steps has put a hair beyond a limit as the one at the limit.

    Else no line of the tip could begin where a jog of the joints has ended.
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
