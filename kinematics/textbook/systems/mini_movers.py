"""Arms of the Mini-mover's build in the textbook's terms: the Mini-mover 5 and the Alpha II.

The hand's frame has z along the hand (approach) and, with the roll at zero, x upwards in the arm's
plane (normal). Checked answers come from `FiveAxisArm`, the formulas run on numbers of any kind.
Sources: McKerrow, chapter 4, section 16 (the Mini-mover 5 and its elbow triangle); T. Asokan,
Introduction to Robotics, lecture 2.7 (the Alpha II). Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink
from kinematics.chains.urdf import urdf_of_chain
from kinematics.errors import OutOfReach
from kinematics.five_axis.arm import Branch, FiveAxisArm
from kinematics.five_axis.frame import NEAR_AXIS_MM, UPRIGHT
from kinematics.five_axis.nearest import nearest
from kinematics.frames.numbers import atan2, cos, sin, sqrt
from kinematics.frames.transforms import LAST_ROW, Transform
from kinematics.limits import turn_into
from kinematics.presets import preset
from kinematics.spaces import JOINT_NAMES, Joints, Pose, RollFrame
from kinematics.textbook.systems.named import (
    ON_AXIS,
    QUARTER_TURN,
    REACH_MM,
    Miss,
    NamedBranch,
    NamedStep,
    Quantity,
    Solved,
    System,
)
from kinematics.textbook.systems.triangle import (
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


NAMES = ("base", "shoulder", "elbow", "tool_pitch", "tool_roll")


# The Alpha II in its lecture's own terms. Axes 2, 3 and 4 point the other way than those of the
# Mini-mover, so that angles count downwards, and theta4 is -90 degrees with the hand straight on.


def _alpha2() -> FiveAxisArm:
    return preset("alpha2").arm


@dataclass(frozen=True, slots=True)
class Alpha2(MiniBuild):
    """The Alpha II, or any arm of its build, in the angles of the lecture's link table."""

    arm: FiveAxisArm = field(default_factory=_alpha2)

    name: ClassVar[str] = "alpha2"
    title: ClassVar[str] = "Alpha II (five revolute joints)"
    source: ClassVar[str] = "Asokan, Introduction to Robotics, lecture 2.7"
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "frames",
            "z0 up the base, z1, z2, z3 along the parallel axes, z4 and z5 along the hand",
            "frames 3 and 4 share the wrist, where z3 and z4 meet; frame 5 is at the tip",
        ),
        NamedStep(
            "link table",
            "alpha = -90, 0, 0, -90, 0 degrees;  d1 = 215, a2 = a3 = 177.8, d5 = 129.5 mm",
            "z1 = z0 turned by -90 degrees about x1, z4 = z3 turned by -90 degrees about x4",
        ),
        NamedStep(
            "home", "theta4 = -90 degrees", "x4 points up and z4 along the hand, straight on"
        ),
        NamedStep("base", "theta1 = atan2(y, x)", "or half a turn on"),
        NamedStep(
            "wrist",
            "r0 = sqrt(x^2 + y^2) - d5 cos(P),  z0 = z - d1 - d5 sin(P)",
            "P is the hand's pitch above the horizontal",
        ),
        NamedStep("elbow triangle", *ELBOW_TRIANGLE),
        NamedStep(
            "shoulder and elbow",
            "theta2 = -(direction +- lift),  theta3 = +- bend",
            "upper signs for elbow up; both count downwards",
        ),
        NamedStep("tool pitch", "theta4 = -P - theta2 - theta3 - 90 degrees"),
        NamedStep("tool roll", "theta5 = R"),
    )
    drawing: ClassVar[str] = r"""
      z0       elbow    wrist
      |   a2     o========o------> z4, z5
      |        .'    a3     d5   tip
      |      .'
      o====='  shoulder (z1, z2, z3 point into the page)
      | d1
     _|_
    (___) theta1       x0 ->
    """

    def relative(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Return the lecture's angles as relative ones with up positive."""
        base, shoulder, elbow, pitch, roll = joints
        return base, -shoulder, -elbow, -pitch - QUARTER_TURN, roll

    def own(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return relative angles, up positive, as the lecture's."""
        base, shoulder, elbow, wrist, roll = angles
        return base, -shoulder, -elbow, -wrist - QUARTER_TURN, roll

    def chain(self) -> Chain:
        """Return the lecture's link table, limits turned to its signs."""
        height, upper, fore, hand = self.arm.lengths
        rows = (
            (height, 0.0, -QUARTER_TURN),
            (0.0, upper, 0.0),
            (0.0, fore, 0.0),
            (0.0, 0.0, -QUARTER_TURN),
            (hand, 0.0, 0.0),
        )
        lows = self.own(tuple(limits.low_rad for limits in self.arm.limits))
        highs = self.own(tuple(limits.high_rad for limits in self.arm.limits))
        links = tuple(
            DHLink(0.0, d, a, alpha, low=min(low, high), high=max(low, high))
            for (d, a, alpha), low, high in zip(rows, lows, highs, strict=True)
        )
        return Chain(links, name=self.name, joint_names=NAMES)


# The Mini-mover 5: its link table in this project's own joint angles, relative and up positive:
# base; shoulder, the elevation of the upper arm; elbow, forearm less upper arm; wrist pitch, hand
# less forearm; wrist roll.


def _minimover() -> FiveAxisArm:
    return preset("minimover5").arm


@dataclass(frozen=True, slots=True)
class MiniMover(MiniBuild):
    """The Mini-mover 5, or any arm of its build, in relative angles with up positive."""

    arm: FiveAxisArm = field(default_factory=_minimover)

    name: ClassVar[str] = "minimover5"
    title: ClassVar[str] = "Mini-mover 5 (five revolute joints)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 16"
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "base", "theta1 = atan2(y, x)", "the arm's plane holds the tip; or half a turn on"
        ),
        NamedStep(
            "wrist",
            "r0 = sqrt(x^2 + y^2) - d5 cos(P),  z0 = z - d1 - d5 sin(P)",
            "from the tip back along the hand, whose pitch P is given, seen from the shoulder",
        ),
        NamedStep("elbow triangle", *ELBOW_TRIANGLE),
        NamedStep(
            "shoulder",
            "theta2 = direction + lift,  direction = atan2(z0, r0)",
            "elbow up; elbow down takes the lift away. With equal links a2 = a3 = L, "
            "lift = acos(sqrt(r0^2 + z0^2) / 2L)",
        ),
        NamedStep("elbow", "theta3 = -+ bend", "minus for elbow up"),
        NamedStep(
            "wrist pitch", "theta4 = P - theta2 - theta3", "elevations of parallel axes add up"
        ),
        NamedStep("wrist roll", "theta5 = R", "in the hand's frame; plus theta1 in the table's"),
    )
    drawing: ClassVar[str] = r"""
      z        theta3
      |   a2  .o-._  a3
      |    .-'     `-o theta4
      | .-'          | d5
      o' theta2      |
      | d1           v tip, theta5 about the hand
     _|_
    (___) theta1
    """

    def relative(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint values as they are."""
        return joints

    def own(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return the angles as they are."""
        return angles

    def chain(self) -> Chain:
        """Return the link table: alpha = 90, 0, 0, 90, 0 degrees, theta4 offset by 90."""
        height, upper, fore, hand = self.arm.lengths
        rows = (
            (height, 0.0, QUARTER_TURN, 0.0),
            (0.0, upper, 0.0, 0.0),
            (0.0, fore, 0.0, 0.0),
            (0.0, 0.0, QUARTER_TURN, QUARTER_TURN),
            (hand, 0.0, 0.0, 0.0),
        )
        links = tuple(
            DHLink(0.0, d, a, alpha, offset=offset, low=limits.low_rad, high=limits.high_rad)
            for (d, a, alpha, offset), limits in zip(rows, self.arm.limits, strict=True)
        )
        return Chain(links, name=self.name, joint_names=JOINT_NAMES)


def urdf_of_arm(
    arm: FiveAxisArm, *, name: str = "arm", speeds_rad_s: Sequence[float] | None = None
) -> str:
    """Return the URDF document of an arm of the Mini-mover's build, in its own joint angles."""
    return urdf_of_chain(MiniMover(arm).chain(), name=name, speeds=speeds_rad_s)
