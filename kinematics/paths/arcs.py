"""Circular arcs of the tip: through three points, from a posture to a pose.

Units: mm and rad. The circle is that through the start, the via point and the goal; its centre is
the circumcentre of their triangle. The hand turns in proportion to the sweep, as it does along a
straight line; how the via point's pose holds it is not looked at.
"""

from __future__ import annotations

import math
from dataclasses import replace

from kinematics.errors import NoArc
from kinematics.frames.vectors import Vector, add, cross, distance, dot, norm, scale, subtract, unit
from kinematics.geometry import ArmGeometry, Follower, Hand, Point
from kinematics.paths.chords import LINE_TOLERANCE_MM, corners, cut, positive, smooth
from kinematics.paths.curves import HandCurve
from kinematics.paths.traces import Round, turned
from kinematics.spaces import Joints, Pose

LEAST_MM = 0.01
"""Points nearer to one another, or to a line, than this draw no circle: a step moves further."""

Arc = HandCurve[Round]
"""An arc of the tip."""


def arc_path(
    arm: ArmGeometry,
    start: Joints,
    via: Pose,
    goal: Pose,
    tolerance_mm: float = LINE_TOLERANCE_MM,
    *,
    sweep_rad: float | None = None,
) -> tuple[Joints, ...]:
    """Return corners, the start included, of an arc through a via point to a pose.

    Pitch and roll (of six joints the hand's rotation about one axis) go from the start's to the
    goal's in proportion to the sweep; of `via` only x, y and z are used. With `sweep_rad` the arc
    goes by that angle instead of to the goal, which is then no more than a third point of the
    circle, and the hand that is reached at the end: 2 pi is a full circle. Tolerance, posture and
    `PathBroken` are as of `line_path`. Raises `NoArc` for points in a line, or fewer than three.
    """
    follower, tip = beginning(arm, start)
    arc = arc_between(follower, tip, follower.first, via, goal, sweep_rad)
    return corners(smooth(cut(arm, arc, start, tolerance_mm)))


def circle_path(
    arm: ArmGeometry,
    start: Joints,
    via: Pose,
    through: Pose,
    tolerance_mm: float = LINE_TOLERANCE_MM,
) -> tuple[Joints, ...]:
    """Return corners of the full circle through a via point and another, back to where it began.

    The hand is held as at the start; of the two poses only x, y and z are used. See `arc_path`.
    """
    here = arm.fk(start)
    goal = replace(here, x_mm=through.x_mm, y_mm=through.y_mm, z_mm=through.z_mm)
    return arc_path(arm, start, via, goal, tolerance_mm, sweep_rad=math.tau)


def beginning(arm: ArmGeometry, start: Joints) -> tuple[Follower, Point]:
    """Return what keeps the posture of a start along curves, and where the tip is."""
    here = arm.fk(start)
    return arm.line(start, here).follower, (here.x_mm, here.y_mm, here.z_mm)


def arc_between(
    follower: Follower, tip: Point, hand: Hand, via: Pose, goal: Pose, sweep_rad: float | None
) -> Arc:
    """Return the arc from a tip and a hand; see `arc_path`. Raises `NoArc`."""
    middle, end = ((each.x_mm, each.y_mm, each.z_mm) for each in (via, goal))
    trace = round_through(tip, middle, end, sweep_rad)
    return HandCurve(follower, trace, (hand, follower.hand(goal, hand)))


def round_through(start: Point, via: Point, goal: Point, sweep_rad: float | None = None) -> Round:
    """Return the way about the circle through three points, to the third or by a sweep.

    Raises `NoArc`.
    """
    _check(start, via, goal)
    b, c = subtract(via, start), subtract(goal, start)
    normal = cross(b, c)
    weighed = add(
        scale(dot(c, c), cross(normal, b)),
        scale(dot(b, b), cross(c, normal)),
    )
    from_start = scale(0.5 / dot(normal, normal), weighed)
    centre, out = add(start, from_start), scale(-1.0, from_start)
    ahead = cross(unit(normal), out)
    if sweep_rad is None:
        return Round(centre, out, ahead, _angle(subtract(goal, centre), out, ahead), goal)
    sweep = positive("sweep_rad", sweep_rad)
    end = start if sweep == math.tau else turned(centre, out, ahead, sweep)
    return Round(centre, out, ahead, sweep, end)


def _angle(point: Vector, out: Vector, ahead: Vector) -> float:
    return math.atan2(dot(point, ahead), dot(point, out)) % math.tau


def _check(start: Point, via: Point, goal: Point) -> None:
    named = {"start": start, "via point": via, "goal": goal}
    pairs = (("start", "via point"), ("via point", "goal"), ("start", "goal"))
    sides = {pair: distance(named[pair[0]], named[pair[1]]) for pair in pairs}
    (one, two), nearest = min(sides.items(), key=lambda side: side[1])
    if nearest < LEAST_MM:
        remedy = "give three points that lie apart"
        if (one, two) == ("start", "goal"):
            remedy += ", or for a full circle another point of it as the goal, and a sweep of 2 pi"
        raise NoArc(f"{one} and {two} are the same point", remedy, nearest)
    off = norm(cross(subtract(via, start), subtract(goal, start))) / max(sides.values())
    if off < LEAST_MM:
        raise NoArc(
            f"start, via point and goal lie in a line, to within {off:.3f} mm",
            "use a straight line, or a via point beside it",
            off,
        )
