"""Previews: a motion's postures, duration, margins and clearances, before anything is sent.

A preview shows the plan that `move_j`, `move_to` or `move_l` would execute, made by the same code
(resolve.py). Units: mm, rad, s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.errors import ArmError, BadRequest
from armdrive.errors.kinematic import refusal_of
from armdrive.errors.table import error_view
from armdrive.motion.plan import MotionPlan, nearest_goal
from armdrive.motion.resolve import Ground, PlannedMove, naming_frame, pose_of, prepare, resolve
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
from armdrive.runtime.position import MotionSegment, alike
from armdrive.runtime.stop_bounds import run_on, stretches
from armdrive.status import bound_words, joints_view, pose_view, rounded_up
from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry, Branch, Point
from kinematics.guards.path import Clearance, least_clearances
from kinematics.limits import SAME_POSTURE_RAD
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose
from kinematics.text import shown_name

# Measures of a plan: its postures, joint margins and duration.

STEP_MM = 2.0  # no point of the arm moves farther between two postures, except on long paths
MOST_POSTURES = 500  # a longer path is sampled evenly at this many postures


@dataclass(frozen=True, slots=True)
class Margin:
    """How near a joint, or a guarded sum of joints, comes to its bound; negative beyond it.

    `index` is the posture in which it is nearest.
    """

    joint: str
    margin_rad: float
    bound_rad: float
    index: int


def postures_along(arm: ArmGeometry, plan: MotionPlan) -> tuple[Joints, ...]:
    """Return postures along a plan, including its start and every corner."""
    travels = [arm.travel_bound_mm(leg.turns_rad) for leg in plan.legs]
    step_mm = max(STEP_MM, math.fsum(travels) / MOST_POSTURES)
    found = [plan.start.joints]
    for leg, travel in zip(plan.legs, travels, strict=True):
        count = max(math.ceil(travel / step_mm), 1)
        found += [leg.start.towards(leg.end, part / count).joints for part in range(1, count + 1)]
    return tuple(found)


def least_margins(model: ArmModel, postures: Sequence[Joints]) -> tuple[Margin, ...]:
    """Return the least margin of each joint and each guarded sum, the smallest first.

    A leg is straight in joint space, so its margins are smallest at its ends.
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
    bound = min((low, high), key=lambda each: abs(values[index] - each))
    return Margin(name, margin(index), bound, index)


def foreseen_s(config: ArmConfig, controller: Controller, plan: MotionPlan) -> float:
    """Return the approximate duration of a plan on the slowest device that is in specification.

    A queue is driven without a break; each burst waits for the exchange of the previous one. Extra
    bursts that an uncoordinated device needs to stay near its path are not included.
    """
    connection = config.connection
    able = dialect(connection.dialect).abilities
    if able.queued_segments:
        return plan.duration_s
    exchange_s, burst_s = able.traffic.exchange_s(connection.baud), config.motion.planned_burst_s
    return math.fsum(_bursts_s(config, controller, leg, burst_s, exchange_s) for leg in plan.legs)


def _bursts_s(
    config: ArmConfig, controller: Controller, leg: MotionSegment, burst_s: float, exchange_s: float
) -> float:
    steps = max(map(abs, leg.steps(config.transmission)))
    rate_hz = steps / leg.duration_s
    count = max(math.ceil(controller.duration_s(steps, rate_hz) / burst_s - 1e-9), 1)
    one_s = max(leg.duration_s / count, controller.duration_s(steps / count, rate_hz))
    return count * (one_s + exchange_s)


# An alternative to a refused goal: the nearest allowed pose, or joints within their limits.


@dataclass(frozen=True, slots=True)
class NearestGoal:
    """An alternative goal that a plan has shown to be possible: a pose and its posture."""

    pose: Pose
    joints: Joints


def instead_of(ground: Ground, move: SingleMove, refusal: ArmError | None) -> NearestGoal | None:
    """Return an alternative to a refused absolute move; None if nothing is possible."""
    arm, here, near = ground.config.model.arm, ground.here.joints, getattr(refusal, "nearest", None)
    if isinstance(move, JointMove) and isinstance(move.goal, Joints):
        limits = zip(arm.limits, move.goal, strict=True)
        within = Joints(tuple(each.clamp(angle) for each, angle in limits), move.goal.names)
        near = nearest_goal(ground.config, arm.fk(within), here)
    try:
        plan = None if near is None else prepare(PoseMove(near), ground).plan
    except (ArmError, KinematicsError):
        return None
    return None if plan is None else NearestGoal(arm.fk(plan.end.joints), plan.end.joints)


# The postures at a goal: which one a motion takes, and why not the others.


@dataclass(frozen=True, slots=True)
class PostureOption:
    """One posture at the goal; `against` is the reason why it is not taken.

    `allowed` is true if the posture violates no limit and no guard: its joints are a valid goal.
    """

    name: str
    joints: Joints
    taken: bool
    allowed: bool = True
    against: str = ""


def ways_of(
    ground: Ground, move: Move, pose: Pose | None, end: Joints | None
) -> tuple[PostureOption, ...]:
    """Return every posture for a pose, the taken one first; none if the goal is joint angles.

    `end` is the posture at the end of the plan, None without a plan.
    """
    if pose is None or (pose.yaw_rad is not None and not ground.config.model.arm.has_yaw):
        return ()
    found = ground.config.model.arm.branches(pose, ground.here.joints)
    line = isinstance(move, LineMove)
    ways = [_way(ground, each, end, line) for each in _different(found)]
    return tuple(sorted(ways, key=lambda way: not way.taken))


def _different(found: Sequence[Branch]) -> Iterator[Branch]:
    """Yield each posture once: for a stretched arm, elbow up and elbow down are the same."""
    seen: list[Branch] = []
    for posture in found:
        if not any(alike(posture.joints, each.joints, SAME_POSTURE_RAD) for each in seen):
            seen.append(posture)
            yield posture


def _way(ground: Ground, posture: Branch, end: Joints | None, line: bool) -> PostureOption:
    taken = end is not None and alike(posture.joints, end, SAME_POSTURE_RAD)
    if taken:
        return PostureOption(posture.name, posture.joints, taken=True)
    forbidden = _forbidden(ground, posture)
    against = forbidden or _second_choice(ground, posture, end, line)
    return PostureOption(posture.name, posture.joints, taken, not forbidden, against)


def _forbidden(ground: Ground, posture: Branch) -> str:
    """Return which limits or which guard forbid a posture; empty if it is allowed."""
    if posture.violations:
        return "; ".join(map(str, posture.violations))
    broken = ground.config.model.guards.violation(ground.config.model.arm, posture.joints)
    return "" if broken is None else broken.sentence


def _second_choice(ground: Ground, posture: Branch, end: Joints | None, line: bool) -> str:
    """Return why an allowed posture is not taken."""
    if end is None:
        return "allowed at the goal, but not reachable on this path"
    if line:
        return "allowed, but a straight line keeps the posture that it starts in"
    turn, least = (_turn_deg(ground.here.joints, one) for one in (posture.joints, end))
    return f"allowed, but farther: its joints turn by {turn:.0f}° instead of {least:.0f}°"


def _turn_deg(a: Joints, b: Joints) -> float:
    """Return the measure by which the nearest posture is chosen, as an angle."""
    return math.degrees(math.dist(a.angles_rad, b.angles_rad))


STOP_SAMPLES = 32  # postures at which the stopping distance is computed; it varies slowly


@dataclass(frozen=True, slots=True)
class Preview:
    """The preview of a motion, or the reason why it is refused.

    - `ways`: the possible postures at the goal.
    - `path`: the tip's points along the path, starting at the present one; `postures`: the arm at
      each of these points, at most about 2 mm of travel apart.
    - `duration_s`: the plan's duration; `slowest_s`: that on the slowest device in specification.
    - `margins`: each joint's least distance from its limits; `clearances`: each guard's. The
      smallest come first.
    - `stop_time_s`, `stop_distance_mm`: the worst stop along the path.
    - `hindrance`: why the arm cannot move at present (for instance disabled or not referenced);
      the plan is valid nevertheless. `problem`: what is wrong with the goal or the path.
    - `nearest`: an alternative to a refused goal.
    - `resolved`: the absolute move. For a grasp, and for fingers without a stepper motor, this is
      all that can be known in advance.
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
    nearest: NearestGoal | None = None
    goal: Pose | None = None
    resolved: Move | None = None

    @property
    def refusal(self) -> ArmError | None:
        """The error that the motion would raise now, if any."""
        return self.hindrance or self.problem

    @property
    def possible(self) -> bool:
        """Whether the motion would be executed now."""
        return self.refusal is None

    @property
    def end(self) -> Joints | None:
        """The posture at the end of the path, None without a plan."""
        return None if self.plan is None else self.plan.end.joints

    @property
    def margin(self) -> Margin | None:
        """The smallest margin of a joint."""
        return self.margins[0] if self.margins else None

    def __str__(self) -> str:
        refused = [] if self.refusal is None else [f"refused: {self.refusal}"]
        return "\n".join([*preview_lines(self), *refused])


def preview_move(
    ground: Ground, controller: Controller, move: Move, hindrance: ArmError | None
) -> Preview:
    """Resolve a move from the arm's position, plan it, and measure it. Nothing is sent.

    `hindrance` is the reason why the arm cannot move at present, if any. Raises `BadRequest` for a
    joint or a frame that the arm does not have.
    """
    absolute = move if isinstance(move, MoveSequence | ParkMove) else resolve(move, ground)
    single = None if isinstance(absolute, MoveSequence) else absolute
    asked = None if single is None else pose_of(single, ground)
    planned, problem = _planned(ground, move, absolute)
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
    samples = (*postures[:: max(len(postures) // STOP_SAMPLES, 1)], postures[-1])
    parts = stretches(ground.config.transmission, plan.legs)
    runs_on = run_on(ground.config, controller, burst_s, parts)
    # without a part no motor turns, and nothing has to be stopped
    bounds = [runs_on.bound(ground.config, each) for each in samples if parts]
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
        runs_on.time_s if parts else 0.0,
        max((bound.distance_mm for bound in bounds), default=0.0),
        goal=asked,
        resolved=planned.resolved,
    )


def _planned(
    ground: Ground, move: Move, absolute: Move
) -> tuple[PlannedMove | None, ArmError | None]:
    try:
        with naming_frame(move):
            return prepare(absolute, ground), None
    except BadRequest:
        raise
    except ArmError as refusal:
        return None, refusal
    except KinematicsError as error:
        return None, refusal_of(error)


# A preview as lines of text, and as plain data.

# the smallest margins and clearances are enough for a person; programs get all of them
MARGINS_SHOWN = 2
CLEARANCES_SHOWN = 3


def preview_lines(preview: Preview) -> Iterator[str]:
    """Yield a preview as lines of text, without its refusal."""
    for way in preview.ways:
        yield way_line(way)
    if preview.plan is not None:
        yield f"leads to {preview.plan.end.joints}"
        yield duration_words(preview)
        yield from (margin_words(one) for one in preview.margins[:MARGINS_SHOWN])
        yield from (clearance_words(preview, one) for one in preview.clearances[:CLEARANCES_SHOWN])
        if preview.stop_time_s:
            stop = bound_words(preview.stop_time_s, preview.stop_distance_mm)
            yield f"a stop on the way takes at most {stop}"
    if preview.hindrance is not None and preview.problem is not None:
        yield f"the motion itself would be refused: {preview.problem}"
    nearest = preview.nearest
    if nearest is not None:
        yield f"possible instead: {nearest.pose}, at {nearest.joints}"


def way_line(way: PostureOption) -> str:
    """Return a line about a posture, and why it is taken or not."""
    sign = "->" if way.taken else "  "
    because = "taken" if way.taken else way.against
    return f"{sign} {way.name or 'the nearest posture found':<22} {way.joints}   ({because})"


def duration_words(preview: Preview) -> str:
    """Return a line about the duration, also on a slow device if that takes longer."""
    if not preview.duration_s:
        return "no motor turns: the arm stands there already"
    planned, slowest = f"{preview.duration_s:.1f} s", f"{preview.slowest_s:.1f} s"
    slow = f", up to about {slowest} on a slow arm"
    return f"takes {planned}" + slow * (slowest != planned)


def margin_words(margin: Margin) -> str:
    """Return a line about a joint's margin."""
    away, bound = math.degrees(margin.margin_rad), math.degrees(margin.bound_rad)
    name = shown_name(margin.joint)
    return f"{name} stays {away:.1f}° from its limit of {bound:.1f}°"


def clearance_words(preview: Preview, clearance: Clearance) -> str:
    """Return a line about a guard's clearance."""
    share = share_of_way(preview, clearance.index)
    where = {0.0: "at the start", 1.0: "at the goal"}.get(share, f"{share:.0%} of the way")
    return f"{clearance.guard}: {round(clearance.clearance_mm)} mm ({clearance.quantity}), {where}"


def share_of_way(preview: Preview, index: int) -> float:
    """Return the share of the path at which one of its postures is."""
    last = len(preview.postures) - 1
    return index / last if last > 0 else 1.0


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
        "stop_time_s": rounded_up(preview.stop_time_s, 3),
        "stop_distance_mm": rounded_up(preview.stop_distance_mm, 1),
        "nearest": None
        if nearest is None
        else {"pose": pose_view(nearest.pose), "joints": joints_view(nearest.joints)},
        "path_mm": [[round(each, 2) for each in point] for point in preview.path],
    }
