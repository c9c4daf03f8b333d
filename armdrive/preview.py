"""A motion as it would be, before anything is sent: ways to hold the hand, duration, margins.

What is shown is the plan that `move_j`, `move_to` or `move_l` would carry out, made by the same
code (goals.py). Units: mm, rad, s.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from armdrive.errors import ArmError, BadRequest
from armdrive.foresight import Margin, foreseen_s, least_margins, postures_along
from armdrive.furthest import Furthest, instead_of
from armdrive.goals import Goal, Ground
from armdrive.stopping import run_on, stretches
from armdrive.ways import Way, ways_of
from kinematics.errors import KinematicsError
from kinematics.guards.path import Clearance, least_clearances

if TYPE_CHECKING:
    from armdrive.controllers.controller import Controller
    from armdrive.planning import Plan
    from kinematics import Joints, Pose
    from kinematics.geometry import Point

Refusal = ArmError | KinematicsError

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
    go instead.
    """

    start: Joints | None
    hindrance: Refusal | None = None
    problem: Refusal | None = None
    ways: tuple[Way, ...] = ()
    plan: Plan | None = field(default=None, repr=False)
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

    @property
    def refusal(self) -> Refusal | None:
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
        from armdrive.previewing import preview_lines  # only people need the words

        return "\n".join(preview_lines(self))


def preview_goal(
    ground: Ground, controller: Controller, goal: Goal, fraction: float, hindrance: Refusal | None
) -> Preview:
    """Plan a motion from where the arm stands, and measure it. Nothing is sent.

    `hindrance` is why the arm would not move anywhere now. Raises `BadRequest` for a goal that is
    none: a joint or a frame that nobody knows.
    """
    asked = goal.pose(ground)
    plan, problem = _planned(ground, goal, fraction)
    here = ground.here.joints
    if plan is None:
        ways = ways_of(ground, goal, asked, None)
        instead = instead_of(ground, goal, problem, fraction)
        return Preview(here, hindrance, problem, ways, nearest=instead, goal=asked)
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
        ways_of(ground, goal, asked, plan.end.joints),
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
    )


def _planned(ground: Ground, goal: Goal, fraction: float) -> tuple[Plan | None, Refusal | None]:
    try:
        return goal.plan(ground, fraction), None
    except BadRequest:
        raise
    except (ArmError, KinematicsError) as refusal:
        return None, refusal
