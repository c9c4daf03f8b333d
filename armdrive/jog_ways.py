"""Where a jog leads: the point after a time at given rates, joint by joint or on the tip's line.

Rates are rad/s and mm/s. A way leads from one unrounded point; it is straight in joint space or
straight in x, y, z, pitch, roll and yaw. Nothing here asks how fast that may be.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from armdrive.whereabouts import Coordinates
from kinematics import Joints, KinematicsError, Pose
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.tool_arm import ToolArm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from armdrive.armfile import ArmConfig
    from kinematics import ArmGeometry
    from kinematics.frames.vectors import Vector

HOP_S = 0.1
"""A posture so far ahead is not solved from the start, but from one on the way there."""

AT_ONCE_RAD = 0.5
"""A joint that turns further than this within a hop takes another posture."""

FURTHER_S = (0.0, 0.02, 0.1)
"""How much further than where a line ends its reason is looked for."""

ELSEWHERE = "the arm would have to take another posture at once"

Span = tuple[float, float]


class Way(Protocol):
    """What the course of a jog needs of a way."""

    def at(self, time_s: float) -> Coordinates | None:
        """Return the point after a time, None where no posture within the limits reaches it."""

    def why(self, time_s: float) -> KinematicsError | str:
        """Say why there is no point after a time."""


@dataclass(frozen=True, slots=True)
class JointWay:
    """Joints and gripper turn at rates, each until it meets its limit; none without `spans`."""

    start: Coordinates
    rates: Sequence[float]
    spans: Sequence[Span] | None = None

    def at(self, time_s: float) -> Coordinates:
        """Return the point after a time."""
        here = (*self.start.joints, self.start.opening_mm)
        there = [a + rate * time_s for a, rate in zip(here, self.rates, strict=True)]
        if self.spans is not None:
            bounded = zip(there, self.spans, strict=True)
            there = [min(max(a, low), high) for a, (low, high) in bounded]
        *angles, opening_mm = there
        return Coordinates(Joints(tuple(angles), self.start.joints.names), opening_mm)

    def why(self, time_s: float) -> KinematicsError | str:  # noqa: ARG002
        """Say nothing: there always is a point."""
        return ""


class TipWay:
    """The tip goes straight on, and the fingers slide within `span_mm`."""

    def __init__(
        self, config: ArmConfig, start: Coordinates, rates: Sequence[float], span_mm: Span
    ) -> None:
        self._arm: ArmGeometry = config.model.arm
        self._start = start
        self._rates = rates
        self._span_mm = span_mm
        self._pose = self._arm.fk(start.joints)
        self._solved: list[tuple[float, Joints]] = [(0.0, start.joints)]

    def at(self, time_s: float) -> Coordinates | None:
        """Return the point after a time, None where no posture within the limits reaches it."""
        low, high = self._span_mm
        opening_mm = min(max(self._start.opening_mm + self._rates[-1] * time_s, low), high)
        if not any(self._rates[:-1]):
            return Coordinates(self._start.joints, opening_mm)
        joints = self._joints(time_s)
        return None if joints is None else Coordinates(joints, opening_mm)

    def why(self, time_s: float) -> KinematicsError | str:
        """Say why there is no point after a time."""
        _, before = self._before(time_s)
        for (
            further_s
        ) in FURTHER_S:  # at the very edge, one solver still finds what another does not
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
            joints = _near(self._arm, self.pose(next_s), before)
            if joints is None:
                return None
            if max(abs(b - a) for a, b in zip(before, joints, strict=True)) > AT_ONCE_RAD:
                return None
            self._solved.append((next_s, joints))
            before = joints
        return before


def _near(arm: ArmGeometry, pose: Pose, seed: Joints) -> Joints | None:
    """Return the posture for a pose a small step from the seed, None where there is none."""
    if not isinstance(arm, FiveAxisArm | ToolArm):
        from kinematics.chains.arm import near  # few arms are chains

        return near(arm, pose, seed)
    try:
        return arm.ik_near(pose, seed)
    except KinematicsError:
        return None


def in_base(axes: tuple[Vector, Vector, Vector], rates: Sequence[float]) -> tuple[float, ...]:
    """Return the rates of a tip with x, y and z of another frame turned into the base's."""
    x, y, z, *others = rates
    turned = (x * a + y * b + z * c for a, b, c in zip(*axes, strict=True))
    return (*turned, *others)


def spans_of(config: ArmConfig, start: Coordinates) -> tuple[Span, ...]:
    """Return where each joint, and then the gripper, may be: moving back is always allowed."""
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    here = (*start.joints, start.opening_mm)
    ranges = (*bounds, config.model.gripper_range_mm)
    return tuple((min(low, a), max(high, a)) for (low, high), a in zip(ranges, here, strict=True))


def on_limits(config: ArmConfig, start: Coordinates) -> Coordinates:
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
    return Coordinates(Joints(tuple(angles), start.joints.names), start.opening_mm)
