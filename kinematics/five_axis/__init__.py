"""An arm of the Mini-mover's build: forward and inverse kinematics with limits and branches.

    closed_form   every branch for a pose, and the chosen one: the nearest within limits
    nearest       the reachable pose nearest to a goal
    workspace     its reach in a vertical plane

Units: mm and rad. Joint angles are relative (facts of the build: base; shoulder = elevation of
the upper arm; elbow = forearm minus upper arm; wrist pitch = hand minus forearm; wrist roll).
In the arm's plane, with the shoulder s, elbow e and wrist w,
r = a2 cos s + a3 cos(s+e) + a4 cos(s+e+w), z = H + the same of sines, pitch = s+e+w.

The pitch of the task space is seen in the vertical plane through base axis and tip, outwards. A
posture whose tip is behind the base axis (r < 0, "base back") therefore has the task pitch
pi - (s+e+w), and its roll is the wrist's plus pi, because the hand's roll reference turns over
with the base: the pose is the one of the front posture that holds the hand in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from kinematics.errors import KinematicsError, check_fields, finite, require
from kinematics.five_axis import closed_form
from kinematics.five_axis.closed_form import (
    Angles,
    Lengths,
    branch_name,
    elbow_triangle,
    forward_frame,
    nearest_branch,
    plane_tip,
    wrist_distance,
)
from kinematics.five_axis.nearest import nearest, span_refusal
from kinematics.frames.rotations import Matrix3, rotate
from kinematics.frames.transforms import rotation_of
from kinematics.frames.vectors import add
from kinematics.geometry import (
    AXIS_MM,
    NO_TOOL,
    Branch,
    Constraint,
    Follower,
    Hand,
    NotFollowed,
    Point,
    Tool,
    Unreachable,
)
from kinematics.limits import (
    LIMIT_TOLERANCE_RAD,
    JointRange,
    LimitViolation,
    few_turns_each,
    turn_near,
    widened_to,
    wrap,
)
from kinematics.paths.curves import LEAP_RAD, NearFollower, in_proportion
from kinematics.spaces import (
    JOINT_NAMES,
    POSE_EXAMPLE,
    Joints,
    Pose,
    angles_of,
    refuse_yaw,
)
from kinematics.text import shown_name


@dataclass(frozen=True, slots=True)
class FiveAxisArm:
    """Lengths in mm and joint ranges in rad of an arm of the Mini-mover's build.

    `base_height_mm` is the shoulder axis above the table, `hand_mm` the finger tips beyond the
    wrist. With a `tool`, poses are those of its point. Raises `BadNumber` and `KinematicsError` for
    lengths or ranges that make no arm.
    """

    base_height_mm: float
    upper_arm_mm: float
    forearm_mm: float
    hand_mm: float
    limits: tuple[JointRange, ...]
    tool: Tool = NO_TOOL
    joint_names = JOINT_NAMES
    has_yaw = False
    """The hand stays in the plane of base axis and finger tips."""

    def __post_init__(self) -> None:
        check_fields(self, finite, "base_height_mm", "upper_arm_mm", "forearm_mm", "hand_mm")
        if self.upper_arm_mm <= 0.0 or self.forearm_mm <= 0.0 or self.hand_mm < 0.0:
            raise KinematicsError(
                "upper arm and forearm must be longer than 0 mm, the hand not less"
            )
        if len(self.limits) != len(JOINT_NAMES):
            raise KinematicsError(
                f"a range is needed for each of {', '.join(JOINT_NAMES)}; "
                f"{len(self.limits)} were given"
            )

    @property
    def lengths(self) -> Lengths:
        """Base height, upper arm, forearm and hand in mm."""
        return self.base_height_mm, self.upper_arm_mm, self.forearm_mm, self.hand_mm

    @property
    def meaning(self) -> Lengths:
        """The lengths, which give joint angles their meaning; a tool changes nothing about that."""
        return self.lengths

    @property
    def moving_points(self) -> tuple[str, ...]:
        """Elbow, wrist and tip; of an arm with a tool the finger tips too."""
        return ("elbow", "wrist", "fingers", "tip") if self.tool else ("elbow", "wrist", "tip")

    def with_tool(self, tool: Tool) -> FiveAxisArm:
        """Return this arm with a tool in its fingers."""
        return replace(self, tool=tool)

    def fk(self, joints: Joints) -> Pose:
        """Return the pose of a posture; pitch and roll within (-pi, pi].

        A wrist roll of more than half a turn is therefore reported as the same direction nearer
        to zero; `ik` with the posture as its seed finds the turn again.
        """
        angles = _directions(joints)
        if not self.tool:
            x, y, z, pitch, roll = closed_form.forward(angles, self.lengths)
        else:
            base, shoulder, elbow, wrist, roll = angles
            x, y, z = self.points(joints)[-1]
            pitch = shoulder + elbow + wrist
            if x * math.cos(base) + y * math.sin(base) < 0.0:
                pitch, roll = math.pi - pitch, roll + math.pi
        return Pose(x, y, z, wrap(pitch), wrap(roll))

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return base (on the table), shoulder, elbow, wrist and tip as (x, y, z) in mm.

        With a tool the finger tips come before the tip, which is the tool's point.
        """
        base, shoulder, elbow, wrist, _ = _directions(joints)
        cos_base, sin_base = math.cos(base), math.sin(base)
        r, z = 0.0, self.base_height_mm
        found = [(0.0, 0.0, 0.0), (0.0, 0.0, z)]
        links = ((self.upper_arm_mm, shoulder), (self.forearm_mm, shoulder + elbow))
        for length, elevation in (*links, (self.hand_mm, shoulder + elbow + wrist)):
            r += length * math.cos(elevation)
            z += length * math.sin(elevation)
            found.append((r * cos_base, r * sin_base, z))
        if self.tool:
            off = rotate(self.hand_axes(joints), self.tool.offset_mm)
            found.append(add(found[-1], off))
        return tuple(found)

    def violations(self, joints: Joints) -> tuple[LimitViolation, ...]:
        """Return the limits that a posture violates."""
        return _violations(_angles(joints), self.limits)

    def branches(self, pose: Pose, seed: Joints | None = None) -> tuple[Branch, ...]:
        """Return every posture for a pose: base front and back, elbow up and down.

        Normally four. If the finger tips are on the base axis and hold no tool there are two: the
        base is then free and taken from the seed, and the pitch counts with the base in front.
        There are none if upper arm and forearm cannot span the distance. Postures beyond the limits
        are included and marked. Each angle is of the turn nearest to the seed (the zero posture by
        default) that the limits allow.
        """
        require("a pose", pose, Pose, POSE_EXAMPLE)
        if self._is_too_near(pose):
            return ()
        near = _seed(seed, self.limits)
        goal, facing_rad = self._fingers(pose, near)
        found = closed_form.inverse(goal, self.lengths, near, facing_rad)
        turned = ((name, _turned(raw, self.limits, near)) for name, raw in found)
        return tuple(
            Branch(name, Joints(angles), _violations(angles, self.limits))
            for name, angles in turned
        )

    def solve(self, pose: Pose, seed: Joints | None = None) -> Joints | None:
        """Return the posture within limits nearest to the seed, or None: `ik` without reasons.

        Nearest is by the sum of the squares of the joints' changes. On the base axis, where no
        direction is outwards, a pitch and its mirror image are the same elevation of the hand: the
        mirror image is used if only it can be held.
        """
        if self._is_too_near(pose):
            return None
        near = _seed(seed, self.limits)
        found = nearest_branch(*self._fingers(pose, near), self, near)
        if found is None and _is_over_the_axis(pose):
            found = nearest_branch(*self._fingers(_mirrored(pose), near), self, near)
        return None if found is None else Joints(found)

    def ik(self, pose: Pose, seed: Joints | None = None) -> Joints:
        """Return what `solve` does: the posture within the limits nearest to the seed.

        Raises `Unreachable`, which says which constraint fails, by how much, and which reachable
        pose is nearest. A wrist roll of more than half a turn is found if the seed is nearer to it.
        An angle less than 1e-7 rad beyond a limit becomes the limit. Raises `KinematicsError` for
        a pose with a yaw, which `solve` and `branches` ignore.
        """
        require("a pose", pose, Pose, POSE_EXAMPLE)
        refuse_yaw(pose)
        joints = self.solve(pose, seed)
        if joints is None:
            raise self._refusal(pose, seed)
        return joints

    # The closed form is fast enough for every small step.
    ik_near = ik
    solve_near = solve

    def nearest_pose(self, pose: Pose, seed: Joints | None = None) -> Pose:
        """Return the reachable pose nearest to this one, with a tool the one of its finger tips."""
        if not self.tool:
            return nearest(self, pose, seed).pose
        if self.solve(pose, seed) is not None:
            return pose
        near = _seed(seed, self.limits)
        goal, facing_rad = self._fingers(pose, near)
        found = nearest_branch(goal, facing_rad, self, near)  # if only the point is too near
        return self.fk(nearest(self, Pose(*goal), seed).joints if found is None else Joints(found))

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return the hand's up, side and along as the columns of a matrix in the base frame."""
        return rotation_of(forward_frame(_directions(joints), self.lengths))

    def follower(self, start: Joints) -> Follower:
        """Return what keeps the posture along curves of the tip that begin in it.

        Without a tool it is the branch that is kept.
        """
        origin = self.fk(start)
        limits = widened_to(self.limits, start)
        if self.tool:
            hand = (origin.pitch_rad, origin.roll_rad)
            return NearFollower(replace(self, limits=limits), hand, LEAP_RAD)
        r, _, _ = plane_tip(start[1], start[2], start[3], self.lengths)
        return FiveAxisFollower(
            self.lengths,
            (origin.pitch_rad, start[4]),
            r < -AXIS_MM,
            _elbow_sign(wrap(start[2]), self.limits[2]),
            start[4] - origin.roll_rad,
            limits,
        )

    def travel_bound_mm(self, changes_rad: Sequence[float]) -> float:
        """Return a bound on the travel of any point while the joints turn by this together.

        Each link turns by the sum of the joints before it. If those turn against one another, as on
        a line along which the hand keeps its pitch, the link travels little.
        """
        base, shoulder, elbow, wrist, roll = changes_rad
        _, upper, fore, hand = self.lengths
        hand += self.tool.reach_mm
        fore_rad = abs(shoulder + elbow)
        own_mm = upper * abs(shoulder) + fore * fore_rad + hand * abs(shoulder + elbow + wrist)
        return own_mm + abs(base) * (upper + fore + hand) + abs(roll) * self.tool.beside_mm

    def levers_mm(self, joints: Joints | None) -> tuple[float, ...]:
        """Return each joint axis's distance from the tip; without joints, of the stretched arm.

        Rolling moves only the point of a tool that is beside the hand's own line.
        """
        if joints is None:
            hand = self.hand_mm + self.tool.reach_mm
            whole = hand + self.forearm_mm + self.upper_arm_mm
            return whole, whole, hand + self.forearm_mm, hand, self.tool.beside_mm
        points = self.points(joints)
        tip, base = points[-1], joints[0]
        return (
            math.hypot(tip[0], tip[1]),
            *(_in_plane_mm(centre, tip, base) for centre in points[1:4]),
            self.tool.beside_mm,
        )

    def _refusal(self, pose: Pose, seed: Joints | None) -> Unreachable:
        """Return why no posture was found: the violation of the branch that comes closest."""
        instead = self.nearest_pose(pose, seed)
        if self._is_too_near(pose):
            across, r = abs(self._across(pose.roll_rad)), math.hypot(pose.x_mm, pose.y_mm)
            reason = (
                f"the tool is {across:.1f} mm beside the arm's plane, and the point only {r:.1f} "
                "mm from the base axis"
            )
            return Unreachable(
                reason, Constraint.TOO_NEAR, r, across, "mm", goal=pose, nearest=instead
            )
        branches = self.branches(pose, seed)
        if not branches:
            fingers, _ = self._fingers(pose, _seed(seed, self.limits))
            return span_refusal(pose, fingers, self.lengths, instead)
        best = min(branches, key=lambda branch: branch.excess_rad)
        worst = max(best.violations, key=lambda violation: violation.excess)
        return Unreachable.by_limit(worst.joint, worst.value, worst.bound, pose, instead)

    # A tool's point is R outwards in the plane that the base turns, and c beside it. Both follow
    # from the roll alone, so that the inverse is closed as well: R = sqrt(x^2 + y^2 - c^2), and the
    # base turns to the direction of the point plus atan2(c, R), also where that puts the finger
    # tips over the base axis. Pitch and roll stay the hand's; the pitch counts outwards on the side
    # on which the point is.

    def _across(self, roll: float) -> float:
        """Return how far the tool's point is beside the arm's plane."""
        return self.tool.up_mm * math.sin(roll) + self.tool.side_mm * math.cos(roll)

    def _is_too_near(self, pose: Pose) -> bool:
        """Whether the point is nearer to the base axis than the tool is beside the arm's plane."""
        across = abs(self._across(pose.roll_rad))
        return math.hypot(pose.x_mm, pose.y_mm) < across - AXIS_MM

    def _fingers(self, pose: Pose, near: Angles) -> tuple[Angles, float | None]:
        """Return the goal of the finger tips, and which way the hand leans if a tool needs it.

        If the finger tips are over the base axis, their position does not show the direction, which
        the tool's point needs. If the point is, any direction is as good, and the seed's base is
        used. A point that is too near the axis is taken outwards to where it can be.
        """
        x, y, z, pitch, roll = *pose.position_mm, pose.pitch_rad, pose.roll_rad
        if not self.tool:
            return (x, y, z, pitch, roll), None
        across = self._across(roll)
        upwards = self.tool.up_mm * math.cos(roll) - self.tool.side_mm * math.sin(roll)
        out = math.sqrt(max(x**2 + y**2 - across**2, 0.0))
        towards = near[0] if _is_over_the_axis(pose) else math.atan2(y, x)
        base = towards + math.atan2(across, out)
        out -= self.tool.along_mm * math.cos(pitch) - upwards * math.sin(pitch)
        z -= self.tool.along_mm * math.sin(pitch) + upwards * math.cos(pitch)
        if out < 0.0:  # the finger tips are behind the axis though the point is not
            mirrored = _mirrored(pose)
            pitch, roll, out, base = mirrored.pitch_rad, mirrored.roll_rad, -out, base + math.pi
        return (out * math.cos(base), out * math.sin(base), z, pitch, roll), base


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


def _angles(joints: Joints) -> Angles:
    """Return the five angles. Raises if these are not the joints of this build."""
    return angles_of(joints, JOINT_NAMES)  # type: ignore[return-value]


def _directions(joints: Joints) -> Angles:
    """Return the five angles, those of many turns as the same direction: formulas add them."""
    return few_turns_each(_angles(joints))  # type: ignore[return-value]


def _seed(seed: Joints | None, limits: tuple[JointRange, ...]) -> Angles:
    """Return the seed's angles, with the base within its limits, because a free base takes it."""
    near = (0.0, 0.0, 0.0, 0.0, 0.0) if seed is None else _angles(seed)
    if limits[0].low_rad <= near[0] <= limits[0].high_rad:
        return near
    return (limits[0].clamp(near[0]), *near[1:])


def _turned(angles: Angles, limits: tuple[JointRange, ...], near: Angles) -> Angles:
    b, s, e, w, r = (
        bounds.turned(angle, seed) for angle, bounds, seed in zip(angles, limits, near, strict=True)
    )
    if limits[2].clamp(e) != e:  # an elbow turns by half a circle at most: report the turn needed
        e = angles[2]
    return b, s, e, w, r


def _violations(angles: Angles, limits: tuple[JointRange, ...]) -> tuple[LimitViolation, ...]:
    return tuple(
        LimitViolation(name, angle, bounds.clamp(angle))
        for name, angle, bounds in zip(JOINT_NAMES, angles, limits, strict=True)
        if abs(angle - bounds.clamp(angle)) > LIMIT_TOLERANCE_RAD
    )


# One posture, kept along a straight line or any other curve of the tip.
# A hand is its pitch (seen outwards, of any turn) and the angle of the wrist roll.

# An elbow nearer to straight than this is on neither side; the side allowed by its range is used.
STRAIGHT_RAD = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class FiveAxisFollower:
    """The branch on which a curve is followed.

    `back` says that the tip is behind the base axis, and `elbow_sign` whether the elbow's angle is
    above or below zero: the branch. `ranges` are the arm's limits, widened to the start where it
    lies outside them. The wrist roll is the pose's roll and `roll_offset`.
    """

    lengths: Lengths
    first: Hand
    back: bool
    elbow_sign: float
    roll_offset: float
    ranges: tuple[JointRange, ...]

    @property
    def posture(self) -> str:
        """The branch in words."""
        up = (self.elbow_sign < 0.0) != self.back
        return branch_name(back=self.back, up=up)

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return how a pose holds the hand: pitch and roll turn the shorter way round.

        The roll takes the longer way if the wrist's range forbids the shorter one.
        """
        pitch = turn_near(pose.pitch_rad, near[0])
        change = wrap(pose.roll_rad + self.roll_offset - near[1])
        if not self._rolls_to(near[1] + change):
            other = change - math.copysign(math.tau, change)
            change = other if self._rolls_to(near[1] + other) else change
        return pitch, near[1] + change

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn: pitch and roll in proportion."""
        return in_proportion(a, b, share)

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand, with pitch and roll of any turn."""
        return Pose(*tip, hand[0], hand[1] - self.roll_offset)

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture, with the base's turn nearest to the previous posture.

        Raises `NotFollowed` if the wrist is out of reach or a joint beyond its range.
        """
        x, y, z = tip
        pitch, roll = hand
        height, upper, fore, length = self.lengths
        old_base, old_shoulder, old_elbow, old_wrist, _ = before.angles_rad
        r = math.hypot(x, y)
        base = old_base
        if r > AXIS_MM:
            base += math.remainder(math.atan2(y, x) + math.pi * self.back - base, math.tau)
        if self.back:
            r, pitch = -r, math.pi - pitch
        wrist_r, wrist_z = r - length * math.cos(pitch), z - height - length * math.sin(pitch)
        pair = elbow_triangle(wrist_r, wrist_z, upper, fore, old_shoulder)
        if pair is None:
            raise NotFollowed(self._span(tip, hand[0]))
        shoulder, elbow = pair[self.elbow_sign > 0.0]
        shoulder += math.tau * round((old_shoulder - shoulder) / math.tau)
        elbow += math.tau * round((old_elbow - elbow) / math.tau)
        wrist = pitch - shoulder - elbow
        wrist += math.tau * round((old_wrist - wrist) / math.tau)
        return Joints(self._limited((base, shoulder, elbow, wrist, roll)))

    def _limited(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return the angles, snapped to limits that they exceed by rounding only."""
        snapped = []
        for name, angle, bounds in zip(JOINT_NAMES, angles, self.ranges, strict=True):
            inside = bounds.clamp(angle)
            if abs(angle - inside) > LIMIT_TOLERANCE_RAD:
                raise NotFollowed(
                    f"the {shown_name(name)} would pass its limit of {math.degrees(inside):.1f}°"
                )
            snapped.append(inside)
        return tuple(snapped)

    def _span(self, tip: Point, pitch: float) -> str:
        x, y, z = tip
        distance = wrist_distance(math.hypot(x, y), z, pitch, self.lengths)
        _, upper, fore, _ = self.lengths
        longest = upper + fore
        if distance > longest:
            return f"the wrist would be further away than the {longest:.1f} mm that the arm spans"
        return f"the wrist would be nearer to the shoulder than {abs(upper - fore):.1f} mm"

    def _rolls_to(self, angle: float) -> bool:
        return abs(self.ranges[4].clamp(angle) - angle) <= LIMIT_TOLERANCE_RAD


def _elbow_sign(elbow: float, bounds: JointRange) -> float:
    """Return the side to which the forearm is bent: that of the start, or the allowed one."""
    if abs(elbow) > STRAIGHT_RAD:
        return math.copysign(1.0, elbow)
    return -1.0 if bounds.low_rad < -STRAIGHT_RAD else 1.0
