"""A motion as it would be, before anything is sent: ways to hold the hand, duration, margins.

What is shown is the plan that `move_j`, `move_to` or `move_l` would carry out, made by the same
code (resolve.py). Units: mm, rad, s.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.errors import ArmError, BadRequest
from armdrive.errors.kinematic import refusal_of
from armdrive.errors.table import error_view
from armdrive.motion.jog.bounds import furthest
from armdrive.motion.plan import MotionPlan
from armdrive.motion.resolve import Ground, PlannedMove, pose_of, prepare, resolve
from armdrive.moves import (
    JointMove,
    LineMove,
    Move,
    MoveSequence,
    ParkMove,
    PoseMove,
    SingleMove,
)
from armdrive.registry import dialect
from armdrive.runtime.position import MotionSegment, alike, joints_between
from armdrive.runtime.stop_bounds import run_on, stretches
from armdrive.status import joints_view, pose_view, violation_text
from kinematics.errors import KinematicsError
from kinematics.five_axis.arm import Posture, postures
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards.path import Clearance, least_clearances
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

# What can be foreseen of a plan: the postures on its way, joint margins, and how long it takes.
#
# Units: mm, rad, s.

STEP_MM = 2.0
"""No point of the arm travels further than this between two postures, on all but long ways."""

MOST_POSTURES = 500
"""A way that would need more of them is looked at so often, evenly."""


@dataclass(frozen=True, slots=True)
class Margin:
    """How near a joint, or a guarded sum of joints, comes to a bound: below 0 beyond it.

    `index` is that of the posture in which it does.
    """

    joint: str
    margin_rad: float
    value_rad: float
    bound_rad: float
    index: int


def postures_along(arm: ArmGeometry, plan: MotionPlan) -> tuple[Joints, ...]:
    """Return postures along a plan, its start and every corner among them."""
    travels = [arm.travel_bound_mm(leg.turns_rad) for leg in plan.legs]
    step_mm = max(STEP_MM, math.fsum(travels) / MOST_POSTURES)
    found = [plan.start.joints]
    for leg, travel in zip(plan.legs, travels, strict=True):
        count = max(math.ceil(travel / step_mm), 1)
        found += [leg.start.towards(leg.end, part / count).joints for part in range(1, count + 1)]
    return tuple(found)


def least_margins(model: ArmModel, postures: Sequence[Joints]) -> tuple[Margin, ...]:
    """Return each joint's least distance from its limits, the smallest first, and each sum's.

    A leg is straight in joint space, so that its ends are its worst points: nothing lies between.
    """
    found = []
    for name, bounds in zip(model.arm.joint_names, model.arm.limits, strict=True):
        values = [joints[name] for joints in postures]
        found.append(_least(name, values, bounds.low_rad, bounds.high_rad))
    for one in model.guards.sums:
        sums = [math.fsum(share * each[joint] for joint, share in one.shares) for each in postures]
        found.append(_least(one.name, sums, one.low_rad, one.high_rad))
    return tuple(sorted(found, key=lambda one: one.margin_rad))


def _least(name: str, values: Sequence[float], low: float, high: float) -> Margin:
    def margin(index: int) -> float:
        return min(values[index] - low, high - values[index])

    index = min(range(len(values)), key=margin)
    value = values[index]
    bound = low if value - low <= high - value else high
    return Margin(name, margin(index), value, bound, index)


def foreseen_s(config: ArmConfig, controller: Controller, plan: MotionPlan) -> float:
    """Return about how long a plan takes on the wire, with a device that is as slow as it may be.

    A queue is driven on without a break; bursts wait for one another's exchange. What a device
    that does not coordinate its motors needs besides, to stay near the way, is not foreseen.
    """
    wire = config.connection
    able = dialect(wire.dialect).abilities
    if able.queued_segments:
        return plan.duration_s
    exchange_s, burst_s = able.traffic.exchange_s(wire.baud), config.motion.planned_burst_s
    return math.fsum(_bursts_s(config, controller, leg, burst_s, exchange_s) for leg in plan.legs)


def _bursts_s(
    config: ArmConfig, controller: Controller, leg: MotionSegment, burst_s: float, exchange_s: float
) -> float:
    transmission = config.model.transmission
    if transmission is None or leg.duration_s <= 0.0:
        return leg.duration_s
    steps = max(map(abs, leg.steps(transmission)))
    rate_hz = steps / leg.duration_s
    count = max(math.ceil(controller.duration_s(steps, rate_hz) / burst_s - 1e-9), 1)
    one_s = max(leg.duration_s / count, controller.duration_s(steps / count, rate_hz))
    return count * (one_s + exchange_s)


# Where the arm could go instead of a goal that is refused: near it, or as far as the way is free.
#
# Units: mm, rad.

HALVINGS = 10
"""A way is halved so often: its end is then known to a thousandth of it."""

LEAST_TURN_RAD = math.radians(0.05)
"""What turns no joint by this much leads nowhere."""


LEAST_SHARE = 0.05
"""Less of the way than this is no help to anybody who wants to go it."""


@dataclass(frozen=True, slots=True)
class Furthest:
    """A pose, and the posture in it, that the arm can be moved to, as a plan has shown.

    `share` is how much of the way that was asked for leads there; 1 for the goal's neighbour.
    """

    pose: Pose
    joints: Joints
    share: float = 1.0


def instead_of(ground: Ground, move: SingleMove, refusal: ArmError | None) -> Furthest | None:
    """Return where an absolute move could lead instead; None where every way is barred.

    The nearest pose that the refusal names, if it can be gone to, else as far along the way that
    was asked for as limits and guards leave it free.
    """
    near = getattr(refusal, "nearest", None)
    speed = getattr(move, "speed", 1.0)
    if near is not None:
        same_way = LineMove if isinstance(move, LineMove) else PoseMove
        for each in (same_way(near, speed), PoseMove(near, speed)):
            plan = _plan(ground, each)
            if plan is not None:
                return _furthest(ground, plan.end.joints, 1.0)
    part = _parts(ground, move, near)
    return None if part is None else _furthest_along(ground, part)


def _parts(
    ground: Ground, move: SingleMove, near: Pose | None
) -> Callable[[float], SingleMove] | None:
    """Return what leads to a share of the way that was asked for."""
    arm, here, asked = ground.config.model.arm, ground.here, pose_of(move, ground)
    match move:
        case LineMove() if asked is not None:
            try:
                line = arm.line(here.joints, asked)
            except KinematicsError:
                return None
            return lambda share: LineMove(line.pose(share), move.speed)
        case JointMove(goal=Joints() as end):
            pass
        case PoseMove() if (pose := near or asked) is not None:
            solved = arm.solve(pose, here.joints)
            if solved is None:
                return None
            end = solved
        case _:
            return None
    return lambda share: JointMove(joints_between(here.joints, end, share), move.speed)


def _furthest_along(ground: Ground, part: Callable[[float], SingleMove]) -> Furthest | None:
    share, _ = furthest(lambda each: _plan(ground, part(each)) is not None, 1.0, HALVINGS)
    if share < LEAST_SHARE or (plan := _plan(ground, part(share))) is None:
        return None
    found = _furthest(ground, plan.end.joints, share)
    moved = zip(found.joints, ground.here.joints, strict=True)
    return found if max(abs(b - a) for a, b in moved) >= LEAST_TURN_RAD else None


def _plan(ground: Ground, move: SingleMove) -> MotionPlan | None:
    try:
        return prepare(move, ground).plan
    except (ArmError, KinematicsError):
        return None


def _furthest(ground: Ground, joints: Joints, share: float) -> Furthest:
    return Furthest(ground.config.model.arm.fk(joints), joints, share)


# The ways to hold the hand at a goal: which posture a motion takes, and why the others fall out.
#
# Units: rad.

SAME_RAD = 1e-4
"""Postures whose joints differ by less are the same one, but for the last digits of a path."""


@dataclass(frozen=True, slots=True)
class PostureOption:
    """One posture at the goal; `against` says why it is not the one that would be taken.

    `allowed` tells whether the arm may stand like this: its joints are then a goal by themselves.
    """

    name: str
    joints: Joints
    taken: bool
    allowed: bool = True
    against: str = ""


def ways_of(
    ground: Ground, move: Move, pose: Pose | None, end: Joints | None
) -> tuple[PostureOption, ...]:
    """Return every posture for a pose, the taken one first; none where joints were asked for.

    `end` is the posture that the plan leads to, None where there is none.
    """
    if pose is None or (pose.yaw_rad is not None and not ground.config.model.arm.has_yaw):
        return ()
    found = postures(ground.config.model.arm, pose, ground.here.joints)
    line = isinstance(move, LineMove)
    ways = [_way(ground, each, end, line) for each in _different(found)]
    if end is not None and not any(way.taken for way in ways):
        ways.append(
            PostureOption("", end, taken=True)
        )  # of a way that turned a joint all the way round
    return tuple(sorted(ways, key=lambda way: not way.taken))


def _different(found: Sequence[Posture]) -> Iterator[Posture]:
    """Yield each posture once: the elbow of an arm that is stretched out is neither up nor down."""
    seen: list[Posture] = []
    for posture in found:
        if not any(alike(posture.joints, each.joints, SAME_RAD) for each in seen):
            seen.append(posture)
            yield posture


def _way(ground: Ground, posture: Posture, end: Joints | None, line: bool) -> PostureOption:
    taken = end is not None and alike(posture.joints, end, SAME_RAD)
    if taken:
        return PostureOption(posture.name, posture.joints, taken=True)
    forbidden = _forbidden(ground, posture)
    against = forbidden or _second_choice(ground, posture, end, line)
    return PostureOption(posture.name, posture.joints, taken, not forbidden, against)


def _forbidden(ground: Ground, posture: Posture) -> str:
    """Say which limits or which guard keep the arm from standing like this."""
    if posture.violations:
        return "; ".join(map(violation_text, posture.violations))
    broken = ground.config.model.guards.violation(ground.config.model.arm, posture.joints)
    return "" if broken is None else broken.sentence


def _second_choice(ground: Ground, posture: Posture, end: Joints | None, line: bool) -> str:
    """Say why another posture is taken than one that is allowed."""
    if end is None:
        return "allowed at the goal, but not reached on this way"
    if line:
        return "allowed, but a straight line keeps the posture that it begins in"
    turn, least = (_turn_deg(ground.here.joints, one) for one in (posture.joints, end))
    return f"allowed, but further: its joints turn by {turn:.0f}° instead of {least:.0f}°"


def _turn_deg(a: Joints, b: Joints) -> float:
    """Return the measure by which the nearest posture is chosen, as an angle."""
    return math.degrees(math.dist(a.angles_rad, b.angles_rad))


STOPS_LOOKED_AT = 32
"""At so many postures of a way the stopping distance is computed, which changes little between."""


@dataclass(frozen=True, slots=True)
class Preview:
    """What a motion would be, or why it is refused.

    `ways` are the postures that hold the hand at the goal, `path` the tip's points along the way,
    the start first, and `postures` the arm at each of them, no point of it further than about
    2 mm from the last. `duration_s` is the plan's, `slowest_s` about what it is on the wire with
    an arm that is as slow as it may be: nobody knows better before it has moved. `margins` are
    each joint's least distance from its limits and `clearances` each guard's, the smallest first.
    The tip would run on by at most `stop_distance_mm` after a stop. `hindrance` is why the arm
    would go nowhere now, as while it is disabled or not referenced, which leaves the plan in
    place; `problem` is what is wrong with the goal or the way, and `nearest` where the arm could
    go instead. `resolved` is the move as it means the same from anywhere; of fingers that no motor
    steps and of a grasp, it is all that can be foreseen.
    """

    start: Joints | None
    hindrance: ArmError | None = None
    problem: ArmError | None = None
    ways: tuple[PostureOption, ...] = ()
    plan: MotionPlan | None = field(default=None, repr=False)
    postures: tuple[Joints, ...] = field(default=(), repr=False)
    path: tuple[Point, ...] = field(default=(), repr=False)
    duration_s: float = 0.0
    slowest_s: float = 0.0
    margins: tuple[Margin, ...] = ()
    clearances: tuple[Clearance, ...] = ()
    stop_time_s: float = 0.0
    stop_distance_mm: float = 0.0
    nearest: Furthest | None = None
    goal: Pose | None = None
    resolved: Move | None = None

    @property
    def refusal(self) -> ArmError | None:
        """What would be raised if the motion were asked for now."""
        return self.hindrance or self.problem

    @property
    def possible(self) -> bool:
        """Whether the motion would be carried out if it were asked for now."""
        return self.refusal is None

    @property
    def end(self) -> Joints | None:
        """The posture that the way leads to, None without a plan."""
        return None if self.plan is None else self.plan.end.joints

    @property
    def margin(self) -> Margin | None:
        """The joint that comes nearest to a limit of its own."""
        return self.margins[0] if self.margins else None

    @property
    def clearance(self) -> Clearance | None:
        """The guard that the arm comes nearest to."""
        return self.clearances[0] if self.clearances else None

    def __str__(self) -> str:
        return "\n".join(preview_lines(self))


def preview_move(
    ground: Ground, controller: Controller, move: Move, hindrance: ArmError | None
) -> Preview:
    """Resolve a move where the arm stands, plan it, and measure it. Nothing is sent.

    `hindrance` is why the arm would not move anywhere now. Raises `BadRequest` for a move that is
    none: a joint or a frame that the arm does not have.
    """
    absolute = move if isinstance(move, MoveSequence | ParkMove) else resolve(move, ground)
    single = None if isinstance(absolute, MoveSequence) else absolute
    asked = None if single is None else pose_of(single, ground)
    planned, problem = _planned(ground, absolute)
    here = ground.here.joints
    if planned is None:
        ways = ways_of(ground, absolute, asked, None)
        instead = None if single is None else instead_of(ground, single, problem)
        return Preview(here, hindrance, problem, ways, nearest=instead, goal=asked)
    plan = planned.plan
    if plan is None:
        return Preview(here, hindrance, resolved=planned.resolved)
    model = ground.config.model
    postures = postures_along(model.arm, plan)
    burst_s = ground.config.motion.planned_burst_s
    looks = (*postures[:: max(len(postures) // STOPS_LOOKED_AT, 1)], postures[-1])
    parts = stretches(model.transmission, plan.legs)
    runs_on = run_on(ground.config, controller, burst_s, parts)
    bounds = [runs_on.bound(ground.config, each) for each in looks]
    return Preview(
        here,
        hindrance,
        None,
        ways_of(ground, absolute, asked, plan.end.joints),
        plan,
        postures,
        tuple(model.arm.points(each)[-1] for each in postures),
        plan.duration_s,
        foreseen_s(ground.config, controller, plan),
        least_margins(model, postures),
        least_clearances(model.guards.over(model.arm), postures),
        bounds[0].time_s,
        max(bound.distance_mm for bound in bounds),
        goal=asked,
        resolved=planned.resolved,
    )


def _planned(ground: Ground, move: Move) -> tuple[PlannedMove | None, ArmError | None]:
    try:
        return prepare(move, ground), None
    except BadRequest:
        raise
    except ArmError as refusal:
        return None, refusal
    except KinematicsError as error:
        return None, refusal_of(error)


# A preview for people, line by line, and as plain data for programs.

MARGINS_SAID = 2
CLEARANCES_SAID = 3
"""How many of the nearest bounds a person is told; programs get them all."""


def preview_lines(preview: Preview) -> Iterator[str]:
    """Yield what a person wants to know before the arm moves."""
    for way in preview.ways:
        yield way_line(way)
    if preview.plan is not None:
        yield f"leads to {preview.plan.end.joints}"
        yield duration_words(preview)
        yield from (margin_words(one) for one in preview.margins[:MARGINS_SAID])
        yield from (clearance_words(preview, one) for one in preview.clearances[:CLEARANCES_SAID])
        yield (
            f"a stop on the way takes at most {preview.stop_time_s:.2f} s and "
            f"{preview.stop_distance_mm:.0f} mm"
        )
    for refusal in (preview.hindrance, preview.problem):
        if refusal is not None:
            yield f"refused: {refusal}"
    if preview.nearest is not None:
        yield nearest_words(preview)


def way_line(way: PostureOption) -> str:
    """Say which posture it is, and why it is taken or not."""
    sign = "->" if way.taken else "  "
    because = "taken" if way.taken else way.against
    return f"{sign} {way.name or 'the nearest posture found':<22} {way.joints}   ({because})"


def duration_words(preview: Preview) -> str:
    """Say how long it takes, with a slow arm too where that is longer."""
    planned, slowest = f"{preview.duration_s:.1f} s", f"{preview.slowest_s:.1f} s"
    slow = f", about {slowest} with an arm that is as slow as it may be"
    return f"takes {planned}" + slow * (slowest != planned)


def margin_words(margin: Margin) -> str:
    """Say how near a joint comes to its limit."""
    away, bound = math.degrees(margin.margin_rad), math.degrees(margin.bound_rad)
    name = margin.joint.replace("_", " ")
    return f"{name} stays {away:.1f}° from its limit of {bound:.1f}°"


def clearance_words(preview: Preview, clearance: Clearance) -> str:
    """Say how near the arm comes to a guard, and where."""
    share = share_of_way(preview, clearance.index)
    where = {0.0: "at the start", 1.0: "at the goal"}.get(share, f"{share:.0%} of the way")
    return f"{clearance.guard}: {round(clearance.clearance_mm)} mm ({clearance.quantity}), {where}"


def share_of_way(preview: Preview, index: int) -> float:
    """Return the share of the way at which one of its postures is."""
    last = len(preview.postures) - 1
    return index / last if last > 0 else 1.0


def nearest_words(preview: Preview) -> str:
    """Say where the arm could go instead."""
    nearest = preview.nearest
    if nearest is None:
        return ""
    part = "" if nearest.share >= 1.0 else f"{nearest.share:.0%} of this way is free: "
    return f"possible instead: {part}{nearest.pose}, at {nearest.joints}"


def preview_view(preview: Preview) -> dict[str, Any]:
    """Return a preview as plain data, with units in the names."""
    refusal, nearest = preview.refusal, preview.nearest
    return {
        "possible": preview.possible,
        "refusal": None if refusal is None else error_view(refusal),
        "start": joints_view(preview.start),
        "end": joints_view(preview.end),
        "goal": pose_view(preview.goal),
        "ways": [
            {
                "name": way.name,
                "joints": joints_view(way.joints),
                "taken": way.taken,
                "allowed": way.allowed,
                "against": way.against,
            }
            for way in preview.ways
        ],
        "duration_s": round(preview.duration_s, 3),
        "slowest_s": round(preview.slowest_s, 3),
        "margins": [
            {
                "joint": one.joint,
                "margin_deg": round(math.degrees(one.margin_rad), 3),
                "bound_deg": round(math.degrees(one.bound_rad), 3),
                "share": round(share_of_way(preview, one.index), 4),
            }
            for one in preview.margins
        ],
        "clearances": [
            {
                "guard": one.guard,
                "of": one.quantity,
                "clearance_mm": round(one.clearance_mm, 2),
                "share": round(share_of_way(preview, one.index), 4),
            }
            for one in preview.clearances
        ],
        "stop_time_s": round(preview.stop_time_s, 3),
        "stop_distance_mm": round(preview.stop_distance_mm, 1),
        "nearest": None
        if nearest is None
        else {
            "pose": pose_view(nearest.pose),
            "joints": joints_view(nearest.joints),
            "share": round(nearest.share, 4),
        },
        "path_mm": [[round(each, 2) for each in point] for point in preview.path],
    }
