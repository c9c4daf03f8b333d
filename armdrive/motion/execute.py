"""Work that the engine carries out step by step: motion, jogging, gripping, referencing.

A task never sleeps and touches no wire: it yields what it waits for. See runtime/engine.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from armdrive.errors import WrongState
from armdrive.motion.context import MotionContext, way_between
from armdrive.motion.deviation import has_room, in_turn
from armdrive.motion.plan import MotionPlan
from armdrive.motion.segments import SpeedLimits
from armdrive.motion.streaming import NOT_THERE, stream_legs, wait_out_pause
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from armdrive.runtime.states import Event
from armdrive.status import State
from armdrive.tasks import SleepUntil, TaskBody, never
from kinematics.spaces import Joints, Motors, Pose

# Planned motion: a plan cut into bursts that are never longer than announced, then verified.

MOST_BURSTS = 10_000_000
"""No leg needs more of them, however short they are made."""


@dataclass(frozen=True, slots=True)
class Moved:
    """What a motion did: where it ended, on whole steps, and what it cost.

    `rounding_mm` is how far the tip is from the goal because motors stand on whole steps.
    `straying_mm` bounds how far it left the planned way between bursts because the device does
    not coordinate its motors, or a motor took up backlash meanwhile; 0 where neither is so.
    """

    joints: Joints
    pose: Pose
    rounding_mm: float
    duration_s: float
    bursts: int
    straying_mm: float = 0.0
    note: str = ""

    def __str__(self) -> str:
        took = f"{self.duration_s:.1f} s, {self.bursts} exchanges"
        rounding = f"{self.rounding_mm:.2f} mm from the goal by rounding to steps"
        straying = (
            f"on the way at most {self.straying_mm:.1f} mm beside it, since its motors did not "
            "turn in proportion"
        )
        parts = [f"tip {self.pose}", f"{took}, {rounding}"]
        parts += [straying] * (self.straying_mm > 0.0) + [self.note] * bool(self.note)
        return "; ".join(parts)


def follow(wire: MotionContext, plan: MotionPlan) -> TaskBody[Moved]:
    """Carry out an audited plan. Raises `Stopped` where a stop ended it early."""
    core = wire.core
    began_s, bursts_before = wire.now_s, wire.engine.requests_sent
    with in_motion(wire):
        core.plans(plan.legs, core.config.motion.planned_burst_s)
        yield from wire.look_before_motion()
        core.require_reference()
        if core.position.coordinates != plan.start:
            raise WrongState("the arm is no longer where the motion was planned from: plan anew")
        yield from drive_legs(wire, plan.legs, core.config.motion.planned_burst_s)
        yield from wire.verify()
    if wire.stopping and core.position.coordinates != plan.end:
        raise wire.stopped("the motion was stopped before its goal")
    moved = report(wire, plan.end, began_s, bursts_before)
    return replace(moved, note="; ".join(filter(None, (plan.note, moved.note))))


@contextmanager
def in_motion(wire: MotionContext, *, or_homing: bool = False) -> Iterator[None]:
    """Be in the state of motion herein, unless a stop was asked for before it began.

    With `or_homing`, a homing that is under way stays what the arm is at.
    """
    core = wire.core
    homing = or_homing and core.state is State.HOMING
    if not homing:
        if wire.stopping:
            raise wire.stopped("the motion was stopped before it began")
        core.happen(Event.MOVE)
        wire.straying_mm = wire.slow_s = wire.total_s = 0.0
    try:
        yield
    finally:
        if not homing:
            core.settle()
        core.still_since_s = wire.now_s


def report(
    wire: MotionContext, goal: ArmCoordinates, began_s: float, requests_before: int
) -> Moved:
    """Say where the arm is now, and how far that is from the goal."""
    core, arm = wire.core, wire.core.config.model.arm
    joints, _ = core.transmission.to_joints(core.position.acknowledged)
    pose, wanted = arm.fk(joints), arm.fk(goal.joints)
    return Moved(
        joints,
        pose,
        math.dist((pose.x_mm, pose.y_mm, pose.z_mm), (wanted.x_mm, wanted.y_mm, wanted.z_mm)),
        wire.now_s - began_s,
        wire.engine.requests_sent - requests_before,
        wire.straying_mm,
        _slow_note(wire),
    )


def _slow_note(wire: MotionContext) -> str:
    """Say so where most of a queued motion was too slow for a device to drive without pauses."""
    if wire.slow_s <= wire.total_s / 2.0:
        return ""
    slowest_hz = wire.core.controller.usable_rate_hz(0.0)
    return (
        f"driven with pauses: this controller turns a motor no slower than {slowest_hz:.1f} steps/s"
    )


def drive_legs(
    wire: MotionContext,
    legs: tuple[MotionSegment, ...],
    burst_s: float,
    *,
    let_go: Callable[[], bool] | None = None,
) -> TaskBody[None]:
    """Go along legs as the device best can, queued or in bursts, until a stop.

    `let_go` makes it a jog, and tells when the rest of it is given up.
    """
    if not legs or wire.stopping:
        return
    if wire.core.controller.abilities.queued_segments:
        yield from stream_legs(wire, legs, burst_s, let_go)
        return
    for leg in legs:
        yield from follow_leg(wire, leg, burst_s, let_go)


def follow_leg(
    wire: MotionContext,
    leg: MotionSegment,
    burst_s: float,
    let_go: Callable[[], bool] | None = None,
) -> TaskBody[None]:
    """Go along a leg in bursts, each of which lasts `burst_s` at most, until a stop.

    A pause is waited out between two of them; of a jog, it ends the rest.
    """
    core, done, speed_override = wire.core, 0.0, wire.core.speed_override
    jog, released = let_go is not None, let_go or never

    def given_up() -> bool:
        return speed_override.paused or released()

    while done < 1.0 and not (wire.stopping or released()):
        if speed_override.paused:
            if jog:
                return
            yield from wait_out_pause(wire)
            continue
        slowed = replace(leg, duration_s=speed_override.slowed_s(leg.duration_s))
        share = next_share(wire, slowed, burst_s, done)
        speed_override.note_slowed(leg.duration_s * share)
        further = 1.0 if share >= 1.0 - done - 1e-9 else done + share
        there = leg.start.towards(leg.end, further)
        on_the_way = way_between(core.position.acknowledged, there.motors(core.transmission))
        believed = core.belief
        yield from paced_move(wire, there, slowed.duration_s * share, given_up)
        if core.position.coordinates == there:
            done = further
        elif not wire.stopping and not (
            core.belief is believed and on_the_way(core.position.acknowledged)
        ):
            raise WrongState(NOT_THERE.format(core.belief.reason))  # a pause came before it began


def next_share(wire: MotionContext, leg: MotionSegment, burst_s: float, done: float) -> float:
    """Return the share of a leg that the next burst may cover, about all the left ones' equal.

    Its whole steps are counted, so that neither rounding nor the coarseness of the device's
    speeds makes a burst last longer than announced; only a single step may. Of a device that does
    not coordinate its motors, no more than it has room to stray on.
    """
    left = 1.0 - done
    count = max(math.ceil(_leg_takes_s(wire, leg) * left / burst_s - 1e-9), 1)
    while count < MOST_BURSTS:
        share = left / count
        target = leg.start.towards(leg.end, done + share).motors(wire.core.transmission)
        steps = (target - wire.core.position.acknowledged).largest
        duration_s = leg.duration_s * share
        short = steps <= 1 or true_duration_s(wire, steps, duration_s) <= burst_s
        if short and has_room(wire.core, target, _rate_hz(steps, duration_s)):
            return share
        count += 1 + count // (10 if short else 50)
    raise WrongState(NOT_THERE.format("it is beside the way"))


def _leg_takes_s(wire: MotionContext, leg: MotionSegment) -> float:
    busiest = max(map(abs, leg.steps(wire.core.transmission)))
    return true_duration_s(wire, busiest, leg.duration_s)


def true_duration_s(wire: MotionContext, steps: float, duration_s: float) -> float:
    """Return how long the device may take for steps that should take `duration_s` or longer."""
    return wire.core.controller.duration_s(steps, _rate_hz(steps, duration_s))


def paced_move(
    wire: MotionContext,
    there: ArmCoordinates,
    duration_s: float,
    let_go: Callable[[], bool] = never,
) -> TaskBody[None]:
    """Send one burst that takes `duration_s` or longer, if nobody has let go before it begins.

    Where the device's slowest setting is still faster than that, the rest of the time is waited.
    """
    target = there.motors(wire.core.transmission)
    steps = (target - wire.core.position.acknowledged).largest
    rate_hz, until_s = _rate_hz(steps, duration_s), wire.now_s + duration_s
    *first, last = in_turn(wire.core, target, rate_hz) or (target,)
    for corner in first:
        wire.note_straying(target - wire.core.position.acknowledged)
        yield from wire.move(corner, rate_hz, None, let_go)
        if wire.stopping or let_go():
            return
    yield from wire.move(last, rate_hz, there, let_go)
    slowest_hz = wire.core.controller.usable_rate_hz(0.0)
    if steps / slowest_hz < duration_s:
        yield SleepUntil(until_s)


def _rate_hz(steps: float, duration_s: float) -> float:
    return steps / duration_s if duration_s > 0.0 else math.inf


def bench_move(
    wire: MotionContext, speeds: SpeedLimits, steps: Motors, fraction: float
) -> TaskBody[Moved]:
    """Move motors by raw steps, in bursts of jogging length. Knows no limit and no guard."""
    core = wire.core
    began_s, before = wire.now_s, wire.engine.requests_sent
    with in_motion(wire, or_homing=True):
        yield from wire.look_before_motion()
        target = core.position.acknowledged + steps
        start, goal = core.position.coordinates, core.position.coordinates_of(target)
        leg = MotionSegment(start, goal, speeds.duration_s(start, goal, fraction))
        yield from drive_legs(wire, (leg,), core.config.motion.jog_burst_s)
        yield from wire.verify()
    if wire.stopping and core.position.acknowledged != target:
        raise wire.stopped("the motion was stopped before its goal")
    return report(wire, goal, began_s, before)
