"""A frame on the bench: its origin and its rotation, as an operator has laid it out.

Its axes are the columns of `rotation`, seen from the arm's base. Positions in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from kinematics.errors import KinematicsError
from kinematics.frames.rotations import (
    IDENTITY,
    Matrix3,
    from_columns,
    multiply,
    rot_x,
    rot_y,
    rot_z,
    rotate,
    transpose,
)
from kinematics.frames.vectors import Vector, add, cross, norm, subtract, unit
from kinematics.limits import wrap
from kinematics.spaces import Pose

# Points that lay out a frame must be at least this far apart, and off one line: a touch of a
# finger is no better than that.
APART_MM = 1.0


@dataclass(frozen=True, slots=True)
class UserFrame:
    """A frame on the bench, seen from the base.

    Positions count along its axes. Five axes cannot follow a tilted board with the hand, so pitch
    and roll stay the hand's own, against the table, whatever the frame; a yaw counts from the
    direction in which its x points on the table.
    """

    origin_mm: Vector = (0.0, 0.0, 0.0)
    rotation: Matrix3 = IDENTITY

    @classmethod
    def turned(
        cls, origin_mm: Vector, yaw_rad: float = 0.0, pitch_rad: float = 0.0, roll_rad: float = 0.0
    ) -> UserFrame:
        """Return a frame turned by yaw about z, then pitch about its y, then roll about its x."""
        rotation = multiply(rot_z(yaw_rad), rot_y(pitch_rad), rot_x(roll_rad))
        return cls(origin_mm, rotation)

    @classmethod
    def through(cls, origin_mm: Vector, along_x_mm: Vector, in_plane_mm: Vector) -> UserFrame:
        """Return the frame that three touched points lay out.

        Its origin, a point on its x axis, and one of its x-y plane on the side of positive y.
        Raises `KinematicsError` for points too near to one another or on one line.
        """
        along, across = subtract(along_x_mm, origin_mm), subtract(in_plane_mm, origin_mm)
        if norm(along) < APART_MM or norm(cross(along, across)) < APART_MM * norm(along):
            raise KinematicsError(
                f"the three points of a frame must be {APART_MM:g} mm apart and not on one line: "
                "the origin, a point on its x axis, and one to the left of that axis"
            )
        x, z = unit(along), unit(cross(along, across))
        return cls(origin_mm, from_columns(x, cross(z, x), z))

    @property
    def heading_rad(self) -> float:
        """The direction in which x points on the table."""
        return math.atan2(self.rotation[1][0], self.rotation[0][0])

    def to_base(self, pose: Pose) -> Pose:
        """Return a pose of this frame as the base sees it."""
        there = rotate(self.rotation, pose.position_mm)
        return _placed(pose, add(self.origin_mm, there), self.heading_rad)

    def from_base(self, pose: Pose) -> Pose:
        """Return a pose of the base as this frame sees it."""
        off = subtract(pose.position_mm, self.origin_mm)
        return _placed(pose, rotate(transpose(self.rotation), off), -self.heading_rad)


def moved_along(pose: Pose, axes: Matrix3, change: Pose) -> Pose:
    """Return a pose moved by `change` along axes that are columns; angles add up."""
    off = rotate(axes, change.position_mm)
    x, y, z = add(pose.position_mm, off)
    yaw = pose.yaw_rad
    return Pose(
        x,
        y,
        z,
        pose.pitch_rad + change.pitch_rad,
        pose.roll_rad + change.roll_rad,
        None if yaw is None else yaw + (change.yaw_rad or 0.0),
    )


def _placed(pose: Pose, place: Vector, heading_rad: float) -> Pose:
    x, y, z = place
    yaw = None if pose.yaw_rad is None else wrap(pose.yaw_rad + heading_rad)
    return replace(pose, x_mm=x, y_mm=y, z_mm=z, yaw_rad=yaw)
