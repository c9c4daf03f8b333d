"""Any chain of links as what is drawn in space, those with slides included.

A view asks of an arm where its points are, how its hand is held, and how far its joints go. Slides
are counted back from where they are furthest out, in mm where other joints have rad: the zero
posture, by which a view fits its picture, is then the longest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.frames.rotations import Matrix3
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.geometry import Point
from kinematics.guards.guards import Guards
from kinematics.limits import JointRange
from kinematics.spaces import Joints, Pose

NO_GUARDS = Guards(
    table=False, inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None
)
"""Nothing stands about a model."""

FREE_MM = 500.0
"""How far a slide without limits is taken to go."""


@dataclass(frozen=True, slots=True)
class ChainFigure:
    """A chain as views see arms."""

    chain: Chain

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints from the base to the hand."""
        return self.chain.joint_names

    @property
    def limits(self) -> tuple[JointRange, ...]:
        """How far each joint goes; one that turns without end by half a turn either way."""
        return tuple(
            JointRange(low, high) if kind is JointKind.REVOLUTE else JointRange(low - high, 0.0)
            for kind, (low, high) in zip(self.chain.kinds, self._bounds, strict=True)
        )

    @property
    def moving_points(self) -> tuple[str, ...]:
        """Names of the points that move: the end of each link, and the tip."""
        return (*self.chain.joint_names, "tip")

    def joints(self, values: Sequence[float]) -> Joints:
        """Return a chain's own joint values (rad and mm) as a view counts them."""
        shifted = (value - out for value, out in zip(values, self._outmost, strict=True))
        return Joints(tuple(shifted), self.joint_names)

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return the base, the end of each link and the tip, in mm."""
        values = self._values(joints)
        frames = self.chain.frames(values)
        return *map(position_of, frames), position_of(self.chain.fk(values))

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return the tool's axes as the columns of a matrix."""
        return rotation_of(self.chain.fk(self._values(joints)))

    def fk(self, joints: Joints) -> Pose:
        """Return where the tip is, and how far the tool's z axis points up."""
        frame = self.chain.fk(self._values(joints))
        along = frame[0][2], frame[1][2], frame[2][2]
        pitch = math.atan2(along[2], math.hypot(along[0], along[1]))
        return Pose(*position_of(frame), pitch)

    def _values(self, joints: Joints) -> tuple[float, ...]:
        return tuple(value + out for value, out in zip(joints, self._outmost, strict=True))

    @property
    def _bounds(self) -> tuple[tuple[float, float], ...]:
        """Return limits that end, in rad and mm."""
        return tuple(
            (
                low if math.isfinite(low) else -_free(kind),
                high if math.isfinite(high) else _free(kind),
            )
            for kind, (low, high) in zip(self.chain.kinds, self.chain.limits, strict=True)
        )

    @property
    def _outmost(self) -> tuple[float, ...]:
        return tuple(
            0.0 if kind is JointKind.REVOLUTE else high
            for kind, (_, high) in zip(self.chain.kinds, self._bounds, strict=True)
        )


@dataclass(frozen=True, slots=True)
class DrawnChain:
    """What a view asks of a model: its figure, and guards of which there are none."""

    arm: ChainFigure
    guards: Guards = NO_GUARDS


def _free(kind: JointKind) -> float:
    return math.pi if kind is JointKind.REVOLUTE else FREE_MM
