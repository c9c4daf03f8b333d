"""The reachable pose nearest to a goal, keeping pitch and roll if possible, and why not the goal.

Units: mm and rad. In the plane of the arm the answer is exact. The base takes the angle nearest to
the goal's direction for a tip in front of the axis, and nearest to the opposite one for a tip
behind it. For each of the two, the best distance in the plane does not depend on the base, so these
two candidates are enough.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from kinematics.five_axis.closed_form import (
    Angles,
    Dimensions,
    Lengths,
    elbow_triangle,
    forward,
    plane_tip,
    wrist_distance,
)
from kinematics.geometry import AXIS_MM, Constraint, Unreachable
from kinematics.limits import wrap
from kinematics.spaces import Joints, Pose

# The nearest point that the arm can reach in its own plane, with the hand's pitch held.
#
# On bare floats. With the pitch held, the wrist angle follows from shoulder s and elbow e, so the
# postures within limits are a convex polygon of (s, e): the box of the two ranges, cut by the two
# bounds that the wrist's range sets on s + e. The tip maps it into the plane. The nearest image of
# a goal outside is the image of the polygon's rim, or of a line e = 0 or e = pi across it, where
# the map folds. On each of these lines the tip runs along a circle, so that its squared distance
# from a goal is a sinusoid. The tip must stay on its own side of the base axis, since behind it the
# same plane pitch is another pitch of the task: so places where lines cross the axis are candidates
# too, and the place on it at the goal's height.

# An edge whose length is negative by this much is a corner turned inside out by rounding.
SLACK_RAD = 1e-9

# A tip on the base axis counts as in front of it; a tip behind it stays this far away.
BEHIND_MM = 2.0 * AXIS_MM

# Shoulder, elbow, wrist pitch.
PlaneAngles = tuple[float, float, float]


class Edge(NamedTuple):
    """Postures of a plane pitch in a line: s = s0 + ds t and e = e0 + de t, t from low to high."""

    pitch: float
    low: float
    high: float
    s0: float
    ds: float
    e0: float
    de: float

    def angles(self, t: float) -> PlaneAngles:
        """Return shoulder, elbow and wrist at a place of the line, inside it or not."""
        s, e = self.s0 + self.ds * t, self.e0 + self.de * t
        return s, e, self.pitch - s - e

    def tip(self, t: float, lengths: Lengths) -> tuple[float, float]:
        """Return r and z of the tip there."""
        r, z, _ = plane_tip(*self.angles(t), lengths)
        return r, z


def plane_pitches(arm: Dimensions, pitch_rad: float, side: int) -> Iterator[float]:
    """Yield every turn of the plane pitch of a pitch seen outwards that the limits may hold."""
    pitch = wrap(pitch_rad if side > 0 else math.pi - pitch_rad)
    low = sum(bounds.low_rad for bounds in arm.limits[1:4])
    high = sum(bounds.high_rad for bounds in arm.limits[1:4])
    for turn in range(
        math.ceil((low - pitch) / math.tau), math.floor((high - pitch) / math.tau) + 1
    ):
        yield pitch + turn * math.tau


def edges(arm: Dimensions, pitch: float) -> Iterator[Edge]:
    """Yield the rim of the polygon of a plane pitch, and the folds across it."""
    _, shoulder, elbow, wrist, _ = arm.limits
    (s_low, s_high), (e_low, e_high) = (
        (bounds.low_rad, bounds.high_rad) for bounds in (shoulder, elbow)
    )
    f_low, f_high = pitch - wrist.high_rad, pitch - wrist.low_rad  # bounds of s + e
    folds = range(math.ceil(e_low / math.pi), math.floor(e_high / math.pi) + 1)
    found = [
        *(
            Edge(pitch, max(e_low, f_low - s), min(e_high, f_high - s), s, 0.0, 0.0, 1.0)
            for s in (s_low, s_high)
        ),
        *(
            Edge(pitch, max(s_low, f_low - e), min(s_high, f_high - e), 0.0, 1.0, e, 0.0)
            for e in (e_low, e_high, *(fold * math.pi for fold in folds))
        ),
        *(
            Edge(pitch, max(s_low, f - e_high), min(s_high, f - e_low), 0.0, 1.0, f, -1.0)
            for f in (f_low, f_high)
        ),
    ]
    for edge in found:
        if edge.low <= edge.high + SLACK_RAD:
            yield edge._replace(high=max(edge.low, edge.high))


def _candidates(
    arm: Dimensions, pitch: float, goal: tuple[float, float], least_r: float
) -> Iterator[PlaneAngles]:
    """Yield postures of a plane pitch of which one has its tip nearest to a goal (r, z)."""
    yield from _solutions(arm, pitch, *goal)
    yield from _solutions(arm, pitch, least_r, goal[1])
    _, shoulder, elbow, wrist, _ = arm.limits
    for edge in edges(arm, pitch):
        for t in _turning_points(edge, arm.lengths, goal, least_r):
            s, e, _ = edge.angles(t)
            s, e = shoulder.clamp(s), elbow.clamp(e)  # rounding on a corner
            yield s, e, wrist.clamp(pitch - s - e)


def _solutions(arm: Dimensions, pitch: float, r: float, z: float) -> Iterator[PlaneAngles]:
    """Yield the postures within limits whose tip is at a point."""
    height, upper, fore, hand = arm.lengths
    wrist_r, wrist_z = r - hand * math.cos(pitch), z - height - hand * math.sin(pitch)
    ranges = arm.limits[1:4]
    free = (ranges[0].low_rad + ranges[0].high_rad) / 2.0
    for s, e in elbow_triangle(wrist_r, wrist_z, upper, fore, free) or ():
        angles = (s, e, pitch - s - e)
        s, e, w = (one.turned(angle, 0.0) for angle, one in zip(angles, ranges, strict=True))
        if all(one.clamp(angle) == angle for angle, one in zip((s, e, w), ranges, strict=True)):
            yield s, e, w


def _turning_points(
    edge: Edge, lengths: Lengths, goal: tuple[float, float], least_r: float
) -> Iterator[float]:
    """Yield the places of an edge at which its nearest tip to the goal can be."""
    yield edge.low
    yield edge.high
    tips = [edge.tip(quarter * math.pi / 2.0, lengths) for quarter in range(3)]
    _, cosine, sine = _sinusoid([math.dist(tip, goal) ** 2 for tip in tips])
    angles = [math.atan2(-sine, -cosine)]
    mean, cosine, sine = _sinusoid([r for r, _ in tips])
    size, ahead = math.hypot(cosine, sine), least_r - mean
    if abs(ahead) < size:
        crossing = math.acos(ahead / size)
        angles += (math.atan2(sine, cosine) + crossing, math.atan2(sine, cosine) - crossing)
    for angle in angles:
        turned = edge.low + (angle - edge.low) % math.tau
        if turned <= edge.high:
            yield turned


def _sinusoid(values: list[float]) -> tuple[float, float, float]:
    """Return a, b, c of a + b cos t + c sin t by its values at 0, a quarter turn and half a one."""
    first, second, third = values
    mean = (first + third) / 2.0
    return mean, (first - third) / 2.0, second - mean


@dataclass(frozen=True, slots=True)
class Nearest:
    """A pose that the arm reaches, a posture that does it, and its distance from the goal."""

    pose: Pose
    joints: Joints
    distance_mm: float


def nearest(arm: Dimensions, pose: Pose, seed: Joints | None = None) -> Nearest:
    """Return the reachable pose nearest in position to `pose`, with its pitch and roll.

    If no posture within limits has this roll, the result has the nearest roll that the wrist can
    take. If none has this pitch, the result has the nearest pitch that can be held, in steps of a
    degree, and the nearest position at that pitch.
    """
    near = seed.angles_rad if seed else (0.0,) * len(arm.limits)
    found = _held(arm, pose, near)
    changes = (sign * math.radians(step) for step in range(1, 181) for sign in (1.0, -1.0))
    while found is None:  # an arm holds its hand at some pitch
        pitch = wrap(pose.pitch_rad + next(changes))
        found = _held(arm, replace(pose, pitch_rad=pitch), near)
    return found


def _held(arm: Dimensions, pose: Pose, near: tuple[float, ...]) -> Nearest | None:
    """Return the nearest pose of exactly this pitch, or None; its roll is kept if it can be."""
    found = [candidate for side in (1, -1) for candidate in _on_side(arm, pose, near, side)]
    kept = [candidate for candidate in found if candidate.pose.roll_rad == pose.roll_rad]
    return min(kept or found, key=lambda candidate: candidate.distance_mm, default=None)


def _on_side(arm: Dimensions, pose: Pose, near: tuple[float, ...], side: int) -> Iterator[Nearest]:
    """Yield the nearest poses with the tip before (1) or behind (-1) the base axis."""
    outwards = math.atan2(pose.y_mm, pose.x_mm)
    if math.hypot(pose.x_mm, pose.y_mm) <= AXIS_MM:
        outwards = near[0] if side > 0 else near[0] - math.pi
    half_turn = 0.0 if side > 0 else math.pi
    roll = pose.roll_rad + half_turn
    base = arm.limits[0].nearest(outwards + half_turn, near[0])
    wrist_roll = arm.limits[4].nearest(roll, near[4])
    goal = pose.x_mm * math.cos(base) + pose.y_mm * math.sin(base), pose.z_mm
    clearance = 0.0 if side > 0 else BEHIND_MM
    for pitch in plane_pitches(arm, pose.pitch_rad, side):
        tips = (
            (plane_tip(*angles, arm.lengths), angles)
            for angles in _candidates(arm, pitch, goal, side * clearance)
        )
        kept = [
            (math.dist((r, z), goal), angles)
            for (r, z, _), angles in tips
            if side * r >= clearance - AXIS_MM / 2.0
        ]
        if kept:
            _, (s, e, w) = min(kept, key=lambda one: one[0])
            yield _answer(arm, pose, (base, s, e, w, wrist_roll), roll - wrist_roll)


def _answer(arm: Dimensions, pose: Pose, angles: Angles, roll_missed: float) -> Nearest:
    """Return the posture with its pose, which keeps the goal's own pitch and turn of roll."""
    x, y, z, _, _ = forward(angles, arm.lengths)
    missed = wrap(roll_missed)
    roll = pose.roll_rad if abs(missed) < 1e-12 else wrap(pose.roll_rad - missed)
    distance = math.dist((x, y, z), pose.position_mm)
    return Nearest(Pose(x, y, z, pose.pitch_rad, roll), Joints(angles), distance)


# Why a pose cannot be reached, by how much, and the alternative.


def span_refusal(pose: Pose, fingers: Angles, lengths: Lengths, instead: Pose) -> Unreachable:
    """Return the error for a wrist that upper arm and forearm cannot span.

    `fingers` are x, y, z, pitch and roll of the finger tips, which hold the tool.
    """
    _, upper, fore, _ = lengths
    x, y, z, pitch, _ = fingers
    distance = wrist_distance(math.hypot(x, y), z, pitch, lengths)
    longest = upper + fore
    too_far = distance > longest
    bound = longest if too_far else abs(upper - fore)
    gap = abs(distance - bound)
    reason = (
        f"the wrist would be {gap:.1f} mm beyond the {bound:.1f} mm that upper arm and forearm span"
        if too_far
        else f"the wrist would be {gap:.1f} mm nearer to the shoulder than the {bound:.1f} mm "
        "at which forearm folds back on upper arm"
    )
    constraint = Constraint.TOO_FAR if too_far else Constraint.TOO_NEAR
    return Unreachable(reason, constraint, distance, bound, "mm", goal=pose, nearest=instead)
