"""The Mini-mover's build in the textbook's terms: any arm of it, with any signs of its joints.

Source: McKerrow, chapter 4, section 16 (the Mini-mover 5 and its elbow triangle). The hand's
frame has z along the hand (approach) and, with the roll at zero, x upwards in the arm's plane
(normal). Checked answers come from `FiveAxisArm`, the formulas run on numbers of any kind.
Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import ClassVar

from kinematics.errors import OutOfReach
from kinematics.five_axis import Branch, FiveAxisArm, RollFrame
from kinematics.frames import LAST_ROW, Transform
from kinematics.hand_frame import NEAR_AXIS_MM, UPRIGHT
from kinematics.limits import turn_into
from kinematics.nearest import nearest
from kinematics.numbers import atan2, cos, sin, sqrt
from kinematics.spaces import Joints, Pose
from kinematics.systems.named_system import (
    ON_AXIS,
    REACH_MM,
    Miss,
    NamedBranch,
    Quantity,
    Solved,
    System,
)
from kinematics.systems.triangle import (
    FOLDED,
    STRAIGHT_SINE,
    STRETCHED,
    broken_bound,
    triangle,
)

HALF_TURN = math.pi
HAND_SETS_BASE = "the tip is on the base axis: the hand's direction sets the base"
ELBOW_TRIANGLE = (
    "cos(bend) = (r0^2 + z0^2 - a2^2 - a3^2) / (2 a2 a3)",
    "cosine rule in the elbow triangle: upper arm, forearm, and the line from shoulder to wrist",
)


class MiniBuild(System):
    """Base, shoulder, elbow, wrist pitch and wrist roll; the hand's axis meets the base's plane."""

    __slots__ = ()

    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "y_mm", "z_mm", "pitch_rad", "roll_rad")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = MappingProxyType(
        {
            "base front, elbow up": (1.0, -1.0),
            "base front, elbow down": (1.0, 1.0),
            "base back, elbow up": (-1.0, 1.0),
            "base back, elbow down": (-1.0, -1.0),
        }
    )

    arm: FiveAxisArm
    """Lengths and limits, with the limits of the relative angles, up positive."""

    @abstractmethod
    def relative(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Return the system's own joint values as relative angles, up positive."""

    @abstractmethod
    def own(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return relative angles, up positive, as the system's own joint values."""

    def lengths(self) -> dict[str, float]:
        """Return a1 (or d1), a2, a3 and the hand in mm."""
        return dict(zip(("d1", "a2", "a3", "d5"), self.arm.lengths, strict=True))

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        height, upper, fore, hand = self.arm.lengths
        base, shoulder, elbow, wrist, roll = self.relative(joints)
        forearm = shoulder + elbow
        pitch = forearm + wrist
        cb, sb, cp, sp, cr, sr = cos(base), sin(base), cos(pitch), sin(pitch), cos(roll), sin(roll)
        r = upper * cos(shoulder) + fore * cos(forearm) + hand * cp
        z = height + upper * sin(shoulder) + fore * sin(forearm) + hand * sp
        return (
            (sb * sr - cb * sp * cr, sb * cr + cb * sp * sr, cb * cp, cb * r),
            (-(cb * sr) - sb * sp * cr, sb * sp * sr - cb * cr, sb * cp, sb * r),
            (cp * cr, -(cp * sr), sp, z),
            LAST_ROW,
        )

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return x, y, z, pitch and roll of a frame, as far as five axes can give it.

        Raises `NotARotation`. On the base axis the pitch counts in the plane of the hand.
        """
        return _numbers(self.arm.solve_transform(frame).pose)

    def ik_frame(
        self, frame: Transform, seed: Sequence[float] | None = None
    ) -> tuple[tuple[NamedBranch, Miss], ...]:
        """Return every branch for a frame, with what five axes leave of it unmet.

        With the tip on the base axis the hand's direction sets the base, unless it is vertical:
        then the base is free, and the roll is turned to the seed's base. No branch comes back
        where the base cannot turn that way.
        """
        near = self._seed(seed)
        pose = self.arm.solve_transform(frame, Joints(self.relative(near))).pose
        ahead, aside = frame[0][2], frame[1][2]
        on_axis = math.hypot(pose.x_mm, pose.y_mm) <= NEAR_AXIS_MM
        if on_axis:  # the direction of so short a distance means nothing
            pose = replace(pose, x_mm=0.0, y_mm=0.0)
        if not on_axis or math.hypot(ahead, aside) <= UPRIGHT:
            return self._missed(self.ik(_numbers(pose), near), frame)
        found: list[NamedBranch] = []
        front = math.atan2(aside, ahead)
        for words, base, goal in (
            ("base front", front, pose),
            ("base back", front + HALF_TURN, _seen_from_behind(pose)),
        ):
            found += [
                replace(branch, name=branch.name.replace("base front", words))
                for branch in self._with_base(base, goal, near)
            ]
        return self._missed(found, frame)

    def _with_base(self, base: float, pose: Pose, near: tuple[float, ...]) -> list[NamedBranch]:
        """Return the branches of a tip on the base axis whose hand wants this base angle.

        None where the base cannot take it.
        """
        limits = self.arm.limits[0]
        turned = turn_into(base, limits.low_rad, limits.high_rad, self.relative(near)[0])
        if limits.clamp(turned) != turned:
            return []
        seed = self.own((turned, *self.relative(near)[1:]))
        name = self.joint_names[0]
        return [
            replace(
                branch,
                free=tuple(joint for joint in branch.free if joint != name),
                degenerate=branch.degenerate.replace(ON_AXIS, HAND_SETS_BASE),
            )
            for branch in self.ik(_numbers(pose), seed)
        ]

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        height, upper, fore, hand = self.arm.lengths
        (x, y, z, pitch, roll), (side, bend) = goal, signs
        base = atan2(side * y, side * x)
        cp, sp = side * cos(pitch), sin(pitch)
        r0 = side * sqrt(x * x + y * y) - hand * cp
        z0 = z - height - hand * sp
        elbow = triangle(r0, z0, upper, fore, bend)
        wrist = atan2(sp, cp) - elbow.first - elbow.second
        turned = roll + (1.0 - side) / 2.0 * HALF_TURN
        joints = self.own((base, elbow.first, elbow.second, wrist, turned))
        return joints, (Quantity("r0", r0, "mm"), Quantity("z0", z0, "mm"), *elbow.workings())

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        pose = Pose(*goal)
        near = Joints(self.relative(seed))
        found = [self._named(branch, goal) for branch in self.arm.branches(pose, near)]
        if not found:
            raise self._refusal(pose, near)
        return found

    def _named(self, branch: Branch, goal: tuple[float, ...]) -> NamedBranch:
        name = f"base {branch.base.value}, elbow {branch.elbow.value}"
        angles = branch.joints.angles_rad
        elbow, upper, fore = angles[2], self.arm.upper_arm_mm, self.arm.forearm_mm
        losses, free = [], []
        if branch.base_free:
            losses.append(ON_AXIS)
            free.append(self.joint_names[0])
        if abs(math.sin(elbow)) <= STRAIGHT_SINE:
            losses.append(STRETCHED if math.cos(elbow) > 0.0 else FOLDED)
            if upper * math.cos(elbow) + fore <= REACH_MM and upper == fore:
                free.append(self.joint_names[1])
        workings = self._solution(goal, *self.signs[name])[1]
        return NamedBranch(name, self.own(angles), workings, tuple(free), "; ".join(losses))

    def _refusal(self, pose: Pose, near: Joints) -> OutOfReach:
        height, upper, fore, hand = self.arm.lengths
        out = math.hypot(pose.x_mm, pose.y_mm) - hand * math.cos(pose.pitch_rad)
        distance = math.hypot(out, pose.z_mm - height - hand * math.sin(pose.pitch_rad))
        bound = broken_bound(distance, upper, fore)
        return self._out_of_reach(
            "the wrist's distance from the shoulder",
            distance,
            distance if bound is None else bound,
            _numbers(nearest(self.arm, pose, near, RollFrame.HAND).pose),
        )


def _numbers(pose: Pose) -> tuple[float, ...]:
    return pose.x_mm, pose.y_mm, pose.z_mm, pose.pitch_rad, pose.roll_rad


def _seen_from_behind(pose: Pose) -> Pose:
    """Return the pose with pitch and roll counted from the other side of the arm's plane."""
    return Pose(
        pose.x_mm, pose.y_mm, pose.z_mm, HALF_TURN - pose.pitch_rad, pose.roll_rad + HALF_TURN
    )
