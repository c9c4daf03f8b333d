"""The reachable pose nearest to a goal, keeping pitch and roll if possible, and why not the goal.

Units: mm and rad. In the plane of the arm the answer is exact. The base takes the angle nearest to
the goal's direction for a tip in front of the axis, and nearest to the opposite one for a tip
behind it. For each of the two, the best distance in the plane does not depend on the base, so these
two candidates are enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

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
from kinematics.limits import JointRange, wrap
from kinematics.spaces import Joints, Pose

# The nearest point that the arm can reach in its own plane, with the hand's pitch held.
#
# On bare floats. With the pitch held, the wrist angle follows from shoulder s and elbow e, so the
# postures within limits are a convex polygon of (s, e): the box of the two ranges, cut by the two
# bounds that the wrist's range sets on s + e. The tip maps it into the plane. The nearest image of
# a goal outside is the image of the polygon's rim, or of a line e = 0 or e = pi across it, where
# the map folds; each is an arc of a circle, whose nearest point is known in closed form. A last
# bound keeps the tip on its own side of the base axis, since behind it the same plane pitch is
# another pitch of the task; it adds where arcs cross that bound, and the point of the bound at the
# goal's height.

# An edge whose length is negative by this much is a corner turned inside out by rounding.
SLACK_RAD = 1e-9

# Shoulder, elbow, wrist pitch.
PlaneAngles = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class PlaneProblem:
    """A goal (r, z in mm) in the plane at one plane pitch, on one side of the base axis.

    The tip must have `side * r >= clearance_mm`; the side is 1 before the axis and -1 behind it.
    """

    lengths: Lengths
    shoulder: JointRange
    elbow: JointRange
    wrist: JointRange
    pitch: float
    goal: tuple[float, float]
    side: int
    clearance_mm: float

    @property
    def forearm(self) -> tuple[float, float]:
        """Bounds that the wrist's range sets on the forearm's elevation, s + e."""
        return self.pitch - self.wrist.high_rad, self.pitch - self.wrist.low_rad


@dataclass(frozen=True, slots=True)
class Arc:
    """Tips on a circle about (r, z): s = s0 + ds * theta and e = e0 + de * theta, low to high."""

    r: float
    z: float
    radius: float
    low: float
    high: float
    s0: float
    ds: float
    e0: float
    de: float


def plane_problems(
    arm: Dimensions, pitch_rad: float, goal: tuple[float, float], side: int, clearance_mm: float
) -> Iterator[PlaneProblem]:
    """Yield the problem of a goal in the arm's plane for every turn of a pitch seen outwards."""
    plane_pitch = wrap(pitch_rad if side > 0 else math.pi - pitch_rad)
    _, shoulder, elbow, wrist, _ = arm.limits
    low = shoulder.low_rad + elbow.low_rad + wrist.low_rad
    high = shoulder.high_rad + elbow.high_rad + wrist.high_rad
    first = math.ceil((low - plane_pitch) / math.tau)
    last = math.floor((high - plane_pitch) / math.tau)
    for turn in range(first, last + 1):
        pitch = plane_pitch + turn * math.tau
        yield PlaneProblem(arm.lengths, shoulder, elbow, wrist, pitch, goal, side, clearance_mm)


def nearest_in_plane(problem: PlaneProblem) -> tuple[float, PlaneAngles] | None:
    """Return the distance to the goal in mm and the posture nearest to it, or None.

    None means that no posture within the limits holds this pitch on this side.
    """
    r, z = problem.goal
    best: tuple[float, PlaneAngles] | None = None
    for angles in _candidates(problem):
        tip_r, tip_z, _ = plane_tip(*angles, problem.lengths)
        if problem.side * tip_r < problem.clearance_mm - AXIS_MM / 2.0:
            continue
        distance = math.hypot(tip_r - r, tip_z - z)
        if best is None or distance < best[0]:
            best = distance, angles
    return best


def _candidates(problem: PlaneProblem) -> Iterator[PlaneAngles]:
    r, z = problem.goal
    yield from _solutions(problem, r, z)
    yield from _solutions(problem, problem.side * problem.clearance_mm, z)
    for arc in arcs(problem):
        for theta in _turning_points(problem, arc):
            s, e = arc.s0 + arc.ds * theta, arc.e0 + arc.de * theta
            s, e = problem.shoulder.clamp(s), problem.elbow.clamp(e)  # rounding on a corner
            yield s, e, problem.wrist.clamp(problem.pitch - s - e)


def _solutions(problem: PlaneProblem, r: float, z: float) -> Iterator[PlaneAngles]:
    """Yield the postures within limits whose tip is at a point."""
    height, upper, fore, hand = problem.lengths
    wrist_r = r - hand * math.cos(problem.pitch)
    wrist_z = z - height - hand * math.sin(problem.pitch)
    ranges = (problem.shoulder, problem.elbow, problem.wrist)
    free = (problem.shoulder.low_rad + problem.shoulder.high_rad) / 2.0
    for s, e in elbow_triangle(wrist_r, wrist_z, upper, fore, free) or ():
        s, e, w = (
            bounds.turned(angle, 0.0)
            for angle, bounds in zip((s, e, problem.pitch - s - e), ranges, strict=True)
        )
        if all(
            bounds.low_rad <= angle <= bounds.high_rad
            for angle, bounds in zip((s, e, w), ranges, strict=True)
        ):
            yield s, e, w


def arcs(problem: PlaneProblem) -> Iterator[Arc]:
    """Yield the polygon's non-empty edges and the folds across it, as arcs."""
    shoulder, elbow = problem.shoulder, problem.elbow
    for s in (shoulder.low_rad, shoulder.high_rad):
        yield from _shoulder_arc(problem, s)
    folds = range(math.ceil(elbow.low_rad / math.pi), math.floor(elbow.high_rad / math.pi) + 1)
    for e in (elbow.low_rad, elbow.high_rad, *(fold * math.pi for fold in folds)):
        yield from _elbow_arc(problem, e)
    for forearm in problem.forearm:
        yield from _forearm_arc(problem, forearm)


def _hand_offset(problem: PlaneProblem) -> tuple[float, float]:
    """Return where the tip would be with the wrist on the shoulder axis."""
    height, _, _, hand = problem.lengths
    return hand * math.cos(problem.pitch), height + hand * math.sin(problem.pitch)


def _shoulder_arc(problem: PlaneProblem, s: float) -> Iterator[Arc]:
    r, z = _hand_offset(problem)
    _, upper, fore, _ = problem.lengths
    low, high = problem.forearm
    low, high = max(low, s + problem.elbow.low_rad), min(high, s + problem.elbow.high_rad)
    if low <= high + SLACK_RAD:
        centre = r + upper * math.cos(s), z + upper * math.sin(s)
        yield Arc(*centre, fore, low, max(low, high), s, 0.0, -s, 1.0)


def _elbow_arc(problem: PlaneProblem, e: float) -> Iterator[Arc]:
    r, z = _hand_offset(problem)
    _, upper, fore, _ = problem.lengths
    low, high = problem.forearm
    low = max(low - e, problem.shoulder.low_rad)
    high = min(high - e, problem.shoulder.high_rad)
    if low <= high + SLACK_RAD:
        across, along = fore * math.sin(e), upper + fore * math.cos(e)
        turn = math.atan2(across, along)  # from the upper arm to the line shoulder-wrist
        radius = math.hypot(across, along)
        yield Arc(r, z, radius, low + turn, max(low, high) + turn, -turn, 1.0, e, 0.0)


def _forearm_arc(problem: PlaneProblem, forearm: float) -> Iterator[Arc]:
    r, z = _hand_offset(problem)
    _, upper, fore, _ = problem.lengths
    low = max(forearm - problem.elbow.high_rad, problem.shoulder.low_rad)
    high = min(forearm - problem.elbow.low_rad, problem.shoulder.high_rad)
    if low <= high + SLACK_RAD:
        centre = r + fore * math.cos(forearm), z + fore * math.sin(forearm)
        yield Arc(*centre, upper, low, max(low, high), 0.0, 1.0, forearm, -1.0)


def _turning_points(problem: PlaneProblem, arc: Arc) -> Iterator[float]:
    """Yield the angles of an arc at which its nearest point to the goal can be."""
    yield arc.low
    yield arc.high
    r, z = problem.goal
    angles = [math.atan2(z - arc.z, r - arc.r)]
    reach = problem.side * problem.clearance_mm - arc.r
    if abs(reach) < arc.radius:
        crossing = math.acos(reach / arc.radius)
        angles += (crossing, -crossing)
    for angle in angles:
        turned = arc.low + (angle - arc.low) % math.tau
        if turned <= arc.high:
            yield turned


# A tip on the base axis counts as in front of it; a tip behind it stays this far away.
BEHIND_MM = 2.0 * AXIS_MM

# Step of the search for a pitch that can be held; the last step is then bisected.
PITCH_SCAN_RAD = math.radians(1.0)


@dataclass(frozen=True, slots=True)
class Nearest:
    """A pose that the arm reaches, a posture that does it, and its distance from the goal."""

    pose: Pose
    joints: Joints
    distance_mm: float


def nearest(arm: Dimensions, pose: Pose, seed: Joints | None = None) -> Nearest:
    """Return the reachable pose nearest in position to `pose`, with its pitch and roll.

    If no posture within limits has this roll, the result has the nearest roll that the wrist can
    take. If none has this pitch, the result has the nearest possible pitch (to 1e-9 rad), and the
    nearest position at that pitch.
    """
    near = seed.angles_rad if seed else (0.0,) * len(arm.limits)
    return _held(arm, pose, near) or _at_nearest_pitch(arm, pose, near)


def _held(arm: Dimensions, pose: Pose, near: tuple[float, ...]) -> Nearest | None:
    """Return the nearest pose of exactly this pitch, or None; its roll is kept if it can be."""
    found = [candidate for side in (1, -1) for candidate in _on_side(arm, pose, near, side)]
    kept = [candidate for candidate in found if candidate.pose.roll_rad == pose.roll_rad]
    return min(kept or found, key=lambda candidate: candidate.distance_mm, default=None)


def _at_nearest_pitch(arm: Dimensions, pose: Pose, near: tuple[float, ...]) -> Nearest:
    """Return the nearest pose of the nearest possible pitch; some pitch can always be held."""

    def at(change: float) -> Nearest | None:
        turned = replace(pose, pitch_rad=wrap(pose.pitch_rad + change))
        return _held(arm, turned, near)

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
    for problem in plane_problems(arm, pose.pitch_rad, goal, side, clearance):
        found = nearest_in_plane(problem)
        if found:
            yield _answer(arm, pose, (base, *found[1], wrist_roll), roll - wrist_roll)


def _answer(arm: Dimensions, pose: Pose, angles: Angles, roll_missed: float) -> Nearest:
    """Return the posture with its pose, which keeps the goal's own pitch and turn of roll."""
    x, y, z, _, _ = forward(angles, arm.lengths)
    missed = wrap(roll_missed)
    roll = pose.roll_rad if abs(missed) < 1e-12 else wrap(pose.roll_rad - missed)
    distance = math.dist((x, y, z), pose.position_mm)
    return Nearest(Pose(x, y, z, pose.pitch_rad, roll), Joints(angles), distance)


# Why a pose cannot be reached, by how much, and the alternative.


def span_refusal(pose: Pose, lengths: Lengths, instead: Pose) -> Unreachable:
    """Return the error for a wrist that upper arm and forearm cannot span."""
    _, upper, fore, _ = lengths
    r = math.hypot(pose.x_mm, pose.y_mm)
    distance = wrist_distance(r, pose.z_mm, pose.pitch_rad, lengths)
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
