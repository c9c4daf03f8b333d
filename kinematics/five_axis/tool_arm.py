"""An arm of the Mini-mover's build with a tool in its fingers: poses are those of the tool's point.

Units: mm and rad. With the tip's plane turned by the base, the tool's point is R outwards in that
plane and c beside it; both follow from the roll alone, so that the inverse is closed as well:
R = sqrt(x^2 + y^2 - c^2), and the base turns to the direction of the point plus atan2(c, R), also
where that puts the finger tips over the base axis.
Pitch and roll remain the hand's; the pitch counts outwards on the side on which the point is.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from kinematics.errors import KinematicsError
from kinematics.five_axis import FiveAxisArm
from kinematics.frames.rotations import Matrix3
from kinematics.geometry import AXIS_MM, ArmGeometry, Branch, Constraint, Point, Tool, Unreachable
from kinematics.limits import JointRange, LimitViolation, widened_to, wrap
from kinematics.paths.curves import LEAP_RAD, NearFollower
from kinematics.spaces import Joints, Pose


@dataclass(frozen=True, slots=True)
class ToolArm:
    """`bare` with the tool's point in the place of the finger tips."""

    bare: FiveAxisArm
    tool: Tool
    has_yaw = False
    """As of the arm that holds the tool."""

    @property
    def limits(self) -> tuple[JointRange, ...]:
        """The range of each joint."""
        return self.bare.limits

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints from the table to the hand."""
        return self.bare.joint_names

    @property
    def moving_points(self) -> tuple[str, ...]:
        """Elbow, wrist, finger tips, and the tool's point as the tip."""
        return (*self.bare.moving_points[:-1], "fingers", "tip")

    @property
    def meaning(self) -> Hashable:
        """What gives joint angles their meaning: a tool changes nothing about that."""
        return self.bare.meaning

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return up, side and along as the columns of a matrix in the base frame."""
        return self.bare.hand_axes(joints)

    def fk(self, joints: Joints) -> Pose:
        """Return the pose of the tool's point; pitch and roll within (-pi, pi]."""
        *_, point = self.points(joints)
        base, shoulder, elbow, wrist, roll = joints.angles_rad
        pitch = shoulder + elbow + wrist
        if point[0] * math.cos(base) + point[1] * math.sin(base) < 0.0:
            pitch, roll = math.pi - pitch, roll + math.pi
        return Pose(*point, wrap(pitch), wrap(roll))

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return base, shoulder, elbow, wrist, finger tips and the tool's point in mm."""
        found = self.bare.points(joints)
        fingers, tool = found[-1], self.tool
        up, side, along = zip(*self.bare.hand_axes(joints), strict=True)
        x, y, z = (
            at + tool.up_mm * u + tool.side_mm * s + tool.along_mm * a
            for at, u, s, a in zip(fingers, up, side, along, strict=True)
        )
        return (*found, (x, y, z))

    def solve(self, pose: Pose, seed: Joints | None = None) -> Joints | None:
        """Return the posture within the limits nearest to the seed, or None.

        Over the base axis a pitch and its mirror image are the same elevation: see `FiveAxisArm`.
        """
        if self._is_too_near(pose):
            return None
        asked = (pose, _mirrored(pose)) if _is_over_the_axis(pose) else (pose,)
        ways = (self._fingers(each, seed) for each in asked)
        found = (self.bare.solve(fingers, seed, facing_rad=facing) for fingers, facing in ways)
        return next((joints for joints in found if joints is not None), None)

    def branches(self, pose: Pose, seed: Joints | None = None) -> tuple[Branch, ...]:
        """Return every posture for a pose, those beyond the limits included: see `FiveAxisArm`."""
        if self._is_too_near(pose):
            return ()
        fingers, facing_rad = self._fingers(pose, seed)
        return self.bare.branches(fingers, seed, facing_rad=facing_rad)

    def ik(self, pose: Pose, seed: Joints | None = None) -> Joints:
        """Return the posture within the limits nearest to the seed; raises `Unreachable`."""
        if self._is_too_near(pose):
            raise self._beside_the_plane(pose, seed)
        fingers, facing_rad = self._fingers(pose, seed)
        try:
            return self.bare.ik(fingers, seed, facing_rad=facing_rad)
        except Unreachable as refusal:
            mirrored = self.solve(pose, seed)
            if mirrored is not None:
                return mirrored
            raise refusal.instead(self.nearest_pose(pose, seed), goal=pose) from None

    # As of the arm that holds the tool, they are fast enough for every small step.
    ik_near = ik
    solve_near = solve

    def nearest_pose(self, pose: Pose, seed: Joints | None = None) -> Pose:
        """Return the pose of the tool for which the finger tips are nearest to what is asked."""
        if self.solve(pose, seed) is not None:
            return pose
        fingers, facing_rad = self._fingers(pose, seed)
        joints = self.bare.solve(fingers, seed, facing_rad=facing_rad)  # if the point is too near
        if joints is None:
            joints = self.bare.ik(self.bare.nearest_pose(fingers, seed), seed)
        return self.fk(joints)

    def violations(self, joints: Joints) -> tuple[LimitViolation, ...]:
        """Return the limits that a posture breaks."""
        return self.bare.violations(joints)

    def follower(self, start: Joints) -> NearFollower:
        """Return what keeps a posture along curves of the tool's point that begin in it."""
        origin = self.fk(start)
        wide = replace(self, bare=replace(self.bare, limits=widened_to(self.limits, start)))
        return NearFollower(wide, (origin.pitch_rad, origin.roll_rad), LEAP_RAD)

    def travel_bound_mm(self, changes_rad: Sequence[float]) -> float:
        """Return a distance that no point exceeds while the joints turn by this in proportion."""
        _, shoulder, elbow, wrist, roll = changes_rad
        base = abs(changes_rad[0])
        hand = abs(shoulder + elbow + wrist)
        off_mm = math.hypot(self.tool.up_mm, self.tool.side_mm)
        reach_mm = math.hypot(off_mm, self.tool.along_mm)
        return (
            self.bare.travel_bound_mm(changes_rad) + reach_mm * (hand + base) + off_mm * abs(roll)
        )

    def levers_mm(self, joints: Joints | None) -> tuple[float, ...]:
        """Return each joint axis's distance from the tool's point, stretched out of no posture."""
        off_mm = math.hypot(self.tool.up_mm, self.tool.side_mm)
        reach_mm = math.hypot(off_mm, self.tool.along_mm)
        if joints is None:
            *turning, _ = self.bare.levers_mm(None)
            return (*(lever + reach_mm for lever in turning), off_mm)
        _, shoulder, elbow, wrist, _, point = self.points(joints)
        return (
            math.hypot(point[0], point[1]),
            *(_in_plane_mm(centre, point, joints[0]) for centre in (shoulder, elbow, wrist)),
            off_mm,
        )

    def _across(self, roll: float) -> float:
        """Return how far the point is beside the arm's plane."""
        return self.tool.up_mm * math.sin(roll) + self.tool.side_mm * math.cos(roll)

    def _is_too_near(self, pose: Pose) -> bool:
        """Whether the point is nearer to the base axis than the tool is beside the arm's plane."""
        across = abs(self._across(pose.roll_rad))
        return math.hypot(pose.x_mm, pose.y_mm) < across - AXIS_MM

    def _fingers(self, pose: Pose, seed: Joints | None) -> tuple[Pose, float]:
        """Return the pose of the finger tips that brings the point there, and their direction.

        If the finger tips are over the base axis, their position does not show the direction, which
        the point needs. If the point is, any direction is as good, and the seed's base is used. A
        point that is too near the axis is taken outwards to where it can be.
        """
        across = self._across(pose.roll_rad)
        upwards = self.tool.up_mm * math.cos(pose.roll_rad)
        upwards -= self.tool.side_mm * math.sin(pose.roll_rad)
        out = math.sqrt(max(pose.x_mm**2 + pose.y_mm**2 - across**2, 0.0))
        towards = math.atan2(pose.y_mm, pose.x_mm)
        if _is_over_the_axis(pose):
            towards = 0.0 if seed is None else self.limits[0].clamp(seed[0])
        base = towards + math.atan2(across, out)
        cos_pitch, sin_pitch = math.cos(pose.pitch_rad), math.sin(pose.pitch_rad)
        out -= self.tool.along_mm * cos_pitch - upwards * sin_pitch
        z = pose.z_mm - self.tool.along_mm * sin_pitch - upwards * cos_pitch
        if out < 0.0:  # the finger tips are behind the axis though the point is not
            pose, out, base = _mirrored(pose), -out, base + math.pi
        return replace(pose, x_mm=out * math.cos(base), y_mm=out * math.sin(base), z_mm=z), base

    def _beside_the_plane(self, pose: Pose, seed: Joints | None) -> Unreachable:
        across, r = abs(self._across(pose.roll_rad)), math.hypot(pose.x_mm, pose.y_mm)
        return Unreachable(
            f"the tool is {across:.1f} mm beside the arm's plane, and the point only {r:.1f} "
            "mm from the base axis",
            Constraint.TOO_NEAR,
            r,
            across,
            "mm",
            goal=pose,
            nearest=self.nearest_pose(pose, seed),
        )


@runtime_checkable
class TakesTool(Protocol):
    """An arm whose own numbers say where its tool is: `ChainArm`.

    The class itself is not named here: it would load the solver of chains for every arm.
    """

    def with_tool(self, tool: Tool) -> ArmGeometry:
        """Return this arm with a tool in its hand."""


def holding(arm: ArmGeometry, tool: Tool) -> ArmGeometry:
    """Return an arm with a tool in its hand. Raises `KinematicsError` where it cannot take one."""
    if isinstance(arm, FiveAxisArm):
        return ToolArm(arm, tool)
    if isinstance(arm, TakesTool):
        return arm.with_tool(tool)
    raise KinematicsError("this arm already holds a tool")


def _is_over_the_axis(pose: Pose) -> bool:
    """Whether the point is on the base axis, from which no direction leads to it."""
    return math.hypot(pose.x_mm, pose.y_mm) <= AXIS_MM


def _mirrored(pose: Pose) -> Pose:
    """Return the hand of a pose as it counts seen outwards in the opposite direction."""
    pitch, roll = wrap(math.pi - pose.pitch_rad), wrap(pose.roll_rad + math.pi)
    return replace(pose, pitch_rad=pitch, roll_rad=roll)


def _in_plane_mm(centre: Point, point: Point, base: float) -> float:
    """Return the distance of a point from an axis through `centre`, normal to the arm's plane."""
    out = (point[0] - centre[0]) * math.cos(base) + (point[1] - centre[1]) * math.sin(base)
    return math.hypot(out, point[2] - centre[2])
