"""The reachable pose nearest to a goal, its pitch and roll held where any posture holds them.

Units: mm and rad. In the plane of the arm the answer is exact (plane.py). The base takes the
angle nearest to the goal's direction for a tip in front of the axis, and nearest to the opposite
one for a tip behind it; for each of the two the best distance in the plane does not depend on
the base, so these two candidates are enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kinematics.closed_form import AXIS_MM, Angles, forward
from kinematics.limits import JointRange, turn_into, wrap
from kinematics.plane import PlaneProblem, nearest_in_plane
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:
    from kinematics.five_axis import FiveAxisArm, RollFrame

BEHIND_MM = 1e-6
"""A tip on the base axis counts as in front of it; one behind it keeps this far away."""

PITCH_SCAN_RAD = math.radians(1.0)
"""Step of the search for a pitch that can be held; the end of that step is then bisected."""


@dataclass(frozen=True, slots=True)
class Nearest:
    """A pose that the arm reaches, a posture that does it, and its distance from the goal."""

    pose: Pose
    joints: Joints
    distance_mm: float


def nearest(
    arm: FiveAxisArm,
    pose: Pose,
    seed: Joints | None = None,
    roll_frame: RollFrame | None = None,
) -> Nearest:
    """Return the reachable pose nearest in position to `pose`, with its pitch and roll.

    Where no posture within limits has this roll, the roll is the nearest that the wrist can take
    at the base angle nearest to the goal; where none has this pitch, the pitch is the nearest
    that some posture has (to 1e-9 rad), and then the position is the nearest at that pitch.
    The roll is in the hand's frame unless `roll_frame` says otherwise.
    """
    table_roll = float(roll_frame.value) if roll_frame else 0.0
    near = seed.angles_rad if seed else (0.0,) * len(arm.limits)
    for keep_roll in (True, False):
        found = _held(arm, pose, near, table_roll, keep_roll)
        if found:
            return found
    return _at_nearest_pitch(arm, pose, near, table_roll)


def _held(
    arm: FiveAxisArm, pose: Pose, near: tuple[float, ...], table_roll: float, keep_roll: bool
) -> Nearest | None:
    """Return the nearest pose of exactly this pitch, or None."""
    found = [
        candidate
        for side in (1, -1)
        for candidate in _on_side(arm, pose, near, table_roll, keep_roll, side)
    ]
    return min(found, key=lambda candidate: candidate.distance_mm, default=None)


def _at_nearest_pitch(
    arm: FiveAxisArm, pose: Pose, near: tuple[float, ...], table_roll: float
) -> Nearest:
    """Return the nearest pose of the pitch nearest to this one; some pitch can always be held."""

    def at(change: float) -> Nearest | None:
        turned = replace(pose, pitch_rad=wrap(pose.pitch_rad + change))
        for keep_roll in (True, False):
            found = _held(arm, turned, near, table_roll, keep_roll)
            if found:
                return found
        return None

    steps = math.ceil(math.pi / PITCH_SCAN_RAD)
    for step in range(1, steps + 1):
        reached = [
            (edge, at(edge))
            for sign in (1.0, -1.0)
            if at(sign * step * PITCH_SCAN_RAD)
            for edge in (_edge(at, sign * (step - 1) * PITCH_SCAN_RAD, sign * PITCH_SCAN_RAD),)
        ]
        if reached:
            best = min(reached, key=lambda pair: abs(pair[0]))[1]
            if best is not None:
                return best
    raise AssertionError("an arm always holds its hand at some pitch")  # pragma: no cover


def _edge(at: Callable[[float], Nearest | None], start: float, step: float) -> float:
    """Return the change of pitch nearest to `start`, within one step, that can be held."""
    refused, held = 0.0, 1.0
    for _ in range(32):
        middle = (refused + held) / 2.0
        if at(start + middle * step):
            held = middle
        else:
            refused = middle
    return start + held * step


def _on_side(
    arm: FiveAxisArm,
    pose: Pose,
    near: tuple[float, ...],
    table_roll: float,
    keep_roll: bool,
    side: int,
) -> Iterator[Nearest]:
    """Yield the nearest poses with the tip before (1) or behind (-1) the base axis."""
    outwards = math.atan2(pose.y_mm, pose.x_mm)
    if math.hypot(pose.x_mm, pose.y_mm) <= AXIS_MM:
        outwards = near[0] if side > 0 else near[0] - math.pi
    half_turn = 0.0 if side > 0 else math.pi
    roll = pose.roll_rad + half_turn * (1.0 - table_roll)
    ranges = _base_ranges(arm, roll, table_roll) if keep_roll else (arm.limits[0],)
    for bounds in ranges:
        base = _closest(outwards + half_turn, bounds, near[0])
        wrist_roll = arm.limits[4].clamp(_turned(roll + table_roll * base, arm.limits[4], near[4]))
        for angles in _planar(arm, pose, base, wrist_roll, side):
            yield _answer(arm, pose, angles, roll + table_roll * base - wrist_roll)


def _planar(
    arm: FiveAxisArm, pose: Pose, base: float, wrist_roll: float, side: int
) -> Iterator[Angles]:
    """Yield the nearest posture in the plane of one base angle, for every turn of the pitch."""
    cos_base, sin_base = math.cos(base), math.sin(base)
    goal = pose.x_mm * cos_base + pose.y_mm * sin_base, pose.z_mm
    plane_pitch = wrap(pose.pitch_rad if side > 0 else math.pi - pose.pitch_rad)
    _, shoulder, elbow, wrist, _ = arm.limits
    low = shoulder.low_rad + elbow.low_rad + wrist.low_rad
    high = shoulder.high_rad + elbow.high_rad + wrist.high_rad
    clearance = 0.0 if side > 0 else BEHIND_MM
    first = math.ceil((low - plane_pitch) / math.tau)
    last = math.floor((high - plane_pitch) / math.tau)
    for turn in range(first, last + 1):
        pitch = plane_pitch + turn * math.tau
        problem = PlaneProblem(arm.lengths, shoulder, elbow, wrist, pitch, goal, side, clearance)
        found = nearest_in_plane(problem)
        if found:
            yield (base, *found[1], wrist_roll)


def _answer(arm: FiveAxisArm, pose: Pose, angles: Angles, roll_missed: float) -> Nearest:
    """Return the posture with its pose, which keeps the goal's own pitch and turn of roll."""
    x, y, z, _, _ = forward(angles, arm.lengths)
    missed = math.remainder(roll_missed, math.tau)
    roll = pose.roll_rad if abs(missed) < 1e-12 else pose.roll_rad - missed
    distance = math.dist((x, y, z), (pose.x_mm, pose.y_mm, pose.z_mm))
    return Nearest(Pose(x, y, z, pose.pitch_rad, roll), Joints(angles), distance)


def _base_ranges(arm: FiveAxisArm, roll: float, table_roll: float) -> tuple[JointRange, ...]:
    """Return the base angles at which the wrist can give this roll; none where nowhere."""
    base, wrist_roll = arm.limits[0], arm.limits[4]
    if not table_roll:
        turned = _turned(roll, wrist_roll, 0.0)
        return (base,) if wrist_roll.clamp(turned) == turned else ()
    first = math.floor((wrist_roll.low_rad - roll - base.high_rad) / math.tau)
    last = math.ceil((wrist_roll.high_rad - roll - base.low_rad) / math.tau)
    found = []
    for turn in range(first, last + 1):  # wrist roll = roll + base + turn
        offset = roll + turn * math.tau
        low = max(base.low_rad, wrist_roll.low_rad - offset)
        high = min(base.high_rad, wrist_roll.high_rad - offset)
        if low <= high:
            found.append(JointRange(low, high))
    return tuple(found)


def _closest(angle: float, bounds: JointRange, seed: float) -> float:
    """Return the angle of a range whose direction is nearest to that of `angle`."""
    turned = _turned(angle, bounds, seed)
    return bounds.clamp(turned)


def _turned(angle: float, bounds: JointRange, seed: float) -> float:
    return turn_into(angle, bounds.low_rad, bounds.high_rad, seed)
