"""From corners to legs: when each part of a motion is driven, under every limit there is.

A leg is straight in joint space and driven at one speed; where the arm speeds up or slows down,
legs are short, so that their speeds follow the ramp (kinematics/paths/timing.py). Units: rad, mm,
s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from armdrive.runtime.position import ArmCoordinates, MotionSegment
from kinematics.geometry import ArmGeometry
from kinematics.paths.timing import MotionLimits, Point, timed
from kinematics.spaces import Joints
from kinematics.transmission import Transmission

SKIPPED_SHARE = 0.75
"""How much of the tolerance a skipped corner may lie beside the way, so that it holds between."""


@dataclass(frozen=True, slots=True)
class SpeedLimits:
    """The limits that time is computed from: joints in rad/s, gripper in mm/s, motors in Hz.

    A joint comes to its full speed in `ramp_s` (0: at once), or as `accelerations_rad_s2` says of
    it, and its acceleration builds up in `jerk_s`. `limits` are the same for each coordinate: the
    joints, and the opening where a motor drives it.
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
        """Return the least time in which no joint and no motor is faster than its limit."""
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
    """Return the legs of a way that is passed without stopping, at rest at both ends.

    While the speed changes, no leg lasts longer than `longest_s`.
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
    """Return the legs with those made one that a single burst can drive within the tolerance.

    A corner may be left out where the tip passes it, at its time, by less than the tolerance.
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
    """Tell whether one burst may stand for these legs."""
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
