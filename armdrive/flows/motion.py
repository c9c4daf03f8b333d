"""Planned motion: a plan cut into bursts that are never longer than announced, then verified."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.engine import Flow, Until
from armdrive.errors import Stopped, WrongState
from armdrive.planning import Leg
from armdrive.states import Event
from armdrive.status import State

if TYPE_CHECKING:
    from armdrive.core import Coordinates
    from armdrive.flows.exchange import Wire
    from armdrive.planning import Plan, Speeds
    from kinematics import Joints, Motors, Pose


@dataclass(frozen=True, slots=True)
class Moved:
    """What a motion did: where it ended, on whole steps, and what it cost.

    `rounding_mm` is how far the tip is from the goal because motors stand on whole steps.
    """

    joints: Joints
    pose: Pose
    rounding_mm: float
    duration_s: float
    bursts: int
    note: str = ""

    def __str__(self) -> str:
        took = f"{self.duration_s:.1f} s, {self.bursts} exchanges"
        rounding = f"{self.rounding_mm:.2f} mm from the goal by rounding to steps"
        return f"tip {self.pose}; {took}, {rounding}" + (f"; {self.note}" if self.note else "")


def follow(wire: Wire, plan: Plan) -> Flow[Moved]:
    """Carry out an audited plan. Raises `Stopped` where a stop ended it early."""
    core = wire.core
    core.require_reference()
    if core.coordinates != plan.start:
        raise WrongState("the arm is no longer where the motion was planned from: plan it again")
    core.happen(Event.MOVE)
    began_s, bursts_before = wire.now_s, wire.engine.requests_sent
    try:
        for leg in plan.legs:
            yield from _follow_leg(wire, leg, core.config.motion.planned_burst_s)
        yield from wire.verify()
    finally:
        core.settle()
        core.still_since_s = wire.now_s
    if wire.stopping and core.coordinates != plan.end:
        raise Stopped("the motion was stopped before its goal")
    return report(wire, plan.end, began_s, bursts_before)


def report(wire: Wire, goal: Coordinates, began_s: float, requests_before: int) -> Moved:
    """Say where the arm is now, and how far that is from the goal."""
    core, arm = wire.core, wire.core.config.model.arm
    joints, _ = core.transmission.to_joints(core.acknowledged)
    pose, wanted = arm.fk(joints), arm.fk(goal.joints)
    return Moved(
        joints,
        pose,
        math.dist((pose.x_mm, pose.y_mm, pose.z_mm), (wanted.x_mm, wanted.y_mm, wanted.z_mm)),
        wire.now_s - began_s,
        wire.engine.requests_sent - requests_before,
    )


def _follow_leg(wire: Wire, leg: Leg, burst_s: float) -> Flow[None]:
    done = 0.0
    while done < 1.0 and not wire.stopping:
        share = _share(wire, leg, burst_s, done)
        done = 1.0 if share >= 1.0 - done - 1e-9 else done + share
        there = leg.start.towards(leg.end, done)
        target = wire.core.transmission.to_motors(there.joints, there.opening_mm)
        yield from paced_move(wire, target, leg.duration_s * share, there)


def _share(wire: Wire, leg: Leg, burst_s: float, done: float) -> float:
    """Return the share of a leg that the next burst may cover, all bursts of it being equal."""
    transmission = wire.core.transmission
    before = transmission.to_exact(leg.start.joints, leg.start.opening_mm)
    behind = transmission.to_exact(leg.end.joints, leg.end.opening_mm)
    busiest = max(abs(b - a) for a, b in zip(before, behind, strict=True))
    if busiest == 0.0 or leg.duration_s == 0.0:
        return 1.0
    takes_s = true_duration_s(wire, busiest, busiest / leg.duration_s)
    left = 1.0 - done
    return left / max(math.ceil(takes_s * left / burst_s - 1e-9), 1)


def true_duration_s(wire: Wire, steps: float, rate_hz: float) -> float:
    """Return how long the device may take for so many steps of the busiest motor."""
    controller = wire.core.controller
    return steps / controller.usable_rate_hz(rate_hz) * controller.doubt(rate_hz)


def paced_move(
    wire: Wire, target: Motors, duration_s: float, there: Coordinates | None
) -> Flow[None]:
    """Send one burst that takes `duration_s` or longer.

    Where the device's slowest setting is still faster than that, the rest of the time is waited.
    """
    steps = (target - wire.core.acknowledged).largest
    until_s = wire.now_s + duration_s
    yield from wire.move(target, steps / duration_s if duration_s > 0.0 else math.inf, there)
    slowest_hz = wire.core.controller.usable_rate_hz(0.0)
    if steps and steps / slowest_hz < duration_s:
        yield Until(until_s)


def bench_move(wire: Wire, speeds: Speeds, steps: Motors, fraction: float) -> Flow[Moved]:
    """Move motors by raw steps, in bursts of jogging length. Knows no limit and no guard."""
    core = wire.core
    homing = core.state is State.HOMING
    if not homing:
        core.happen(Event.MOVE)
    began_s, before = wire.now_s, wire.engine.requests_sent
    start, goal = core.coordinates, core.coordinates_of(core.acknowledged + steps)
    leg = Leg(start, goal, speeds.duration_s(start, goal, fraction))
    try:
        if steps.largest:
            yield from _follow_leg(wire, leg, core.config.motion.jog_burst_s)
        yield from wire.verify()
    finally:
        if not homing:
            core.settle()
        core.still_since_s = wire.now_s
    if wire.stopping and core.acknowledged != core.transmission.to_motors(
        goal.joints, goal.opening_mm
    ):
        raise Stopped("the motion was stopped before its goal")
    return report(wire, goal, began_s, before)
