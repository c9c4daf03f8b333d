"""The nearest point that the arm can reach in its own plane, with the hand's pitch held.

Lengths in mm, angles in rad, bare floats. With the pitch held, the wrist angle follows from
shoulder s and elbow e, so the postures within limits are a convex polygon of (s, e): the box of
the two ranges, cut by the two bounds that the wrist's range sets on s + e. The tip maps it into
the plane. The nearest image of a goal outside is the image of the polygon's rim, or of a line
e = 0 or e = pi across it, where the map folds; each is an arc of a circle, whose nearest point
is known in closed form. A last bound keeps the tip on its own side of the base axis, since
behind it the same plane pitch is another pitch of the task; it adds where arcs cross that bound,
and the point of the bound at the goal's height.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from kinematics.closed_form import AXIS_MM, Lengths, elbow_triangle, plane_tip
from kinematics.limits import JointRange, turn_into

SLACK_RAD = 1e-9
"""An edge shorter than nothing by this much is a corner that rounding has turned inside out."""

PlaneAngles = tuple[float, float, float]
"""Shoulder, elbow, wrist pitch."""


@dataclass(frozen=True, slots=True)
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


def nearest_in_plane(problem: PlaneProblem) -> tuple[float, PlaneAngles] | None:
    """Return the distance to the goal in mm and the posture nearest to it, or None if none is.

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
            turn_into(angle, bounds.low_rad, bounds.high_rad, 0.0)
            for angle, bounds in zip((s, e, problem.pitch - s - e), ranges, strict=True)
        )
        if all(
            bounds.low_rad <= angle <= bounds.high_rad
            for angle, bounds in zip((s, e, w), ranges, strict=True)
        ):
            yield s, e, w


def arcs(problem: PlaneProblem) -> Iterator[Arc]:
    """Yield the polygon's edges and the folds across it that are not empty, as arcs."""
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
    """Yield the angles of an arc at which its point nearest to the goal can be."""
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
