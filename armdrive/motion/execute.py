"""Executing motion, in bursts or in a stream of queued segments.

A segment is computed at the last moment, when the controller has room for it within the announced
time ahead. Drawn segments are kept, so that a halt can be told from a lost position. A task never
sleeps and never touches the wire: it yields what it waits for (runtime/engine.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain

from armdrive.abilities import segment_s
from armdrive.errors import Stopped, WrongState
from armdrive.motion.context import MotionContext, StreamedCourse, Way
from armdrive.motion.deviation import has_room
from armdrive.motion.plan import MotionPlan, SpeedLimits
from armdrive.runtime.overrides import given_up
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from armdrive.runtime.states import Event
from armdrive.status import State
from armdrive.tasks import MoveAlong, SleepUntil, TaskBody, never
from kinematics.spaces import Joints, Motors, Pose
from kinematics.text import counted

# Waiting in a pause: the arm stands, is polled now and then, and continues where it stopped.

PAUSE_POLL_S = 0.05  # how often a paused motion checks whether it may continue
NOT_THERE = "the arm is no longer where it was paused ({}): the motion has ended, plan it again"


def wait_out_pause(context: MotionContext) -> TaskBody[None]:
    """Wait while the arm is paused, until it is resumed or stopped.

    The position record shows the arm at rest meanwhile. Raises if the pause takes too long, and if
    the arm is no longer in the same place: a motion from elsewhere was never audited.
    """
    speed_override, core = context.core.speed_override, context.core
    if not speed_override.paused or context.stopping:
        return
    yield from context.verify(midway=True)
    core.mark_still()
    stood, believed = core.position.acknowledged, core.belief
    poll_s = core.config.motion.idle_poll_s
    began_s = looked_s = context.now_s
    speed_override.waits = True
    try:
        while speed_override.paused and not context.stopping:
            yield SleepUntil(context.now_s + PAUSE_POLL_S)
            context.require_no_fault()
            waited_s = context.now_s - began_s
            if waited_s >= speed_override.longest_s:
                raise given_up(waited_s)
            if poll_s and context.now_s >= looked_s + poll_s:
                yield from context.look()
                looked_s = context.now_s
    finally:
        speed_override.waits = False
    if context.stopping:
        return
    yield from context.look()  # however fresh the latest reading is: a person may be at the arm
    context.require_no_fault()
    if core.position.acknowledged != stood or core.belief is not believed:
        raise WrongState(NOT_THERE.format(core.belief.reason))


def stream_legs(
    context: MotionContext,
    legs: tuple[MotionSegment, ...],
    ahead_s: float,
    released: Callable[[], bool] | None,
) -> TaskBody[bool]:
    """Stream audited legs; return whether all were driven, or False if something ended them.

    `released` makes the motion a jog, which ends as soon as `released()` is true.
    """
    jog = released is not None
    ways = _slices(context, legs, segment_s(ahead_s))
    while True:
        course = StreamedCourse(context.core, ways)
        segments = course.segments()
        held_back = context.core.speed_override.is_paused
        request = MoveAlong(segments, ahead_s, jog, released or never, held_back)
        driven = yield from context.stream(request, course)
        if driven and course.still_s:
            yield SleepUntil(context.now_s + course.still_s)
            if context.stopping or (released is not None and released()):
                return False
            continue
        # after a pause, continue with the piece that it cut off, then with all that was not drawn
        if course.left is not None:
            ways = chain((course.left,), ways)
        elif course.exhausted:
            return driven
        if jog or not driven:
            return driven
        yield from wait_out_pause(context)
        if context.stopping:
            return False


def _slices(
    context: MotionContext, legs: tuple[MotionSegment, ...], longest_s: float
) -> Iterator[Way]:
    """Cut legs into about equal parts of at most `longest_s` each; end at a stop."""
    speed_override = context.core.speed_override
    for leg in legs:
        done = 0.0
        while done < 1.0:
            if context.stopping:
                return
            left_s = speed_override.slowed_s(leg.duration_s) * (1.0 - done)
            # the subtraction keeps a rounding error from adding an almost empty slice
            count = max(1, math.ceil(left_s / longest_s - 1e-9))
            done = 1.0 if count == 1 else done + (1.0 - done) / count
            yield leg.start.towards(leg.end, done), left_s / count


# Planned motion: bursts that are never longer than announced, followed by verification.

MOST_BURSTS = 10_000_000  # no leg needs more


@dataclass(frozen=True, slots=True)
class Moved:
    """The result of a motion: the final posture, on whole steps, and its cost.

    `rounding_mm` is the tip's distance from the goal due to whole steps. `deviation_mm` bounds the
    tip's deviation from the planned path between bursts, if the device does not coordinate its
    motors or a motor had to take up backlash; otherwise it is 0.
    """

    joints: Joints
    pose: Pose
    rounding_mm: float
    duration_s: float
    bursts: int
    deviation_mm: float = 0.0
    note: str = ""

    def __str__(self) -> str:
        took = f"{self.duration_s:.1f} s, {counted(self.bursts, 'exchange')}"
        rounding = f"{self.rounding_mm:.2f} mm from the goal by rounding to steps"
        deviation = (
            f"up to {self.deviation_mm:.1f} mm off the path, because its motors did not turn in "
            "proportion"
        )
        parts = [f"tip {self.pose}", f"{took}, {rounding}"]
        parts += [deviation] * (self.deviation_mm > 0.0) + [self.note] * bool(self.note)
        return "; ".join(parts)


def follow(context: MotionContext, plan: MotionPlan) -> TaskBody[Moved]:
    """Execute an audited plan. Raises `Stopped` if a stop ends it early."""
    core = context.core
    began_s, bursts_before = context.now_s, context.engine.requests_sent
    with in_motion(context):
        # the bounds of a stop are announced for this plan before its first byte is sent
        core.plans(plan.legs, core.config.motion.planned_burst_s)
        yield from context.look_before_motion()
        core.require_reference()
        # The caller planned before this task began. A motion from anywhere else was never audited.
        if core.position.coordinates != plan.start:
            raise WrongState("the arm has moved since the motion was planned: plan it again")
        yield from drive_legs(context, plan.legs, core.config.motion.planned_burst_s)
        yield from context.verify()
    if context.stopping and core.position.coordinates != plan.end:
        raise context.stopped("the motion was stopped before its goal")
    moved = report(context, plan.end, began_s, bursts_before)
    return replace(moved, note="; ".join(filter(None, (plan.note, moved.note))))


@contextmanager
def in_motion(context: MotionContext, *, or_homing: bool = False) -> Iterator[None]:
    """A context in the state MOVING; raises `Stopped` if a stop was requested beforehand.

    It begins with an empty notice: what the previous motion was answered is no longer true. It does
    not end well in error-stop, or if it was stopped and its position is no longer trusted: the
    reason is raised at the end, also of a jog. With `or_homing`, an arm in the state HOMING stays
    in it.
    """
    core = context.core
    homing = or_homing and core.state is State.HOMING
    if not homing:
        if context.stopping:
            raise context.stopped("the motion was stopped before it began")
        core.happen(Event.MOVE)
        context.deviation_mm = context.slow_s = context.total_s = 0.0
    believed = core.belief
    core.withdraw()
    try:
        yield
        context.require_no_fault()
        if context.stopping and core.belief is not believed:
            belief, why = core.belief, context.engine.stop_why
            words = f"the motion was stopped{why}; its position is {belief.trust.value} now"
            raise Stopped(f"{words}: {belief.reason}")
    finally:
        if not homing:
            core.settle()
        # `Idling` writes the position once the arm has stood for two seconds from here
        core.still_since_s = context.now_s


def report(
    context: MotionContext, goal: ArmCoordinates, began_s: float, requests_before: int
) -> Moved:
    """Return the result of a motion that has ended."""
    core, arm = context.core, context.core.config.model.arm
    joints, _ = core.transmission.to_joints(core.position.acknowledged)
    pose, wanted = arm.fk(joints), arm.fk(goal.joints)
    return Moved(
        joints,
        pose,
        math.dist((pose.x_mm, pose.y_mm, pose.z_mm), (wanted.x_mm, wanted.y_mm, wanted.z_mm)),
        context.now_s - began_s,
        context.engine.requests_sent - requests_before,
        context.deviation_mm,
        _slow_note(context),
    )


def _slow_note(context: MotionContext) -> str:
    """Return a note if most of a streamed motion was too slow to be driven without stops."""
    if context.slow_s <= context.total_s / 2.0:
        return ""
    slowest_hz = context.core.controller.usable_rate_hz(0.0)
    return (
        "driven with stops: armdrive turns a motor of this controller no slower than "
        f"{slowest_hz:.1f} steps/s"
    )


def drive_legs(
    context: MotionContext,
    legs: tuple[MotionSegment, ...],
    burst_s: float,
    *,
    released: Callable[[], bool] | None = None,
) -> TaskBody[None]:
    """Drive along legs, streamed if the device has a queue, otherwise in bursts, until a stop.

    `released` makes the motion a jog, which ends as soon as `released()` is true.
    """
    if not legs or context.stopping:
        return
    if context.core.controller.abilities.queued_segments:
        yield from stream_legs(context, legs, burst_s, released)
        return
    for leg in legs:
        yield from follow_leg(context, leg, burst_s, released)


def follow_leg(
    context: MotionContext,
    leg: MotionSegment,
    burst_s: float,
    released: Callable[[], bool] | None = None,
) -> TaskBody[None]:
    """Drive along a leg in bursts of at most `burst_s` each, until a stop.

    A pause takes effect between two bursts; it ends a jog.
    """
    core, done, speed_override = context.core, 0.0, context.core.speed_override
    jog, is_released = released is not None, released or never

    def given_up() -> bool:
        return speed_override.paused or is_released()

    while done < 1.0 and not (context.stopping or is_released()):
        if speed_override.paused:
            if jog:
                return
            yield from wait_out_pause(context)
            continue
        slowed = replace(leg, duration_s=speed_override.slowed_s(leg.duration_s))
        share = next_share(context, slowed, burst_s, done)
        # end exactly on the corner, because the next leg starts there
        further = 1.0 if share >= 1.0 - done - 1e-9 else done + share
        there = leg.start.towards(leg.end, further)
        believed = core.belief
        # a pause drops a burst that has not begun to move: then the same share is tried again
        yield from paced_move(context, there, slowed.duration_s * share, given_up)
        # Only a burst that arrived counts as done. One that was dropped, or cut short by a pause on
        # its way, is planned again from where the motors are; anything else ends the motion.
        if core.position.coordinates == there:
            done = further
        elif not context.stopping and core.belief is not believed:
            raise WrongState(NOT_THERE.format(core.belief.reason))  # paused before it started


def next_share(context: MotionContext, leg: MotionSegment, burst_s: float, done: float) -> float:
    """Return the share of a leg for the next burst; the remaining bursts are about equally long.

    The burst's whole steps are counted, so that neither rounding nor coarse speed settings make it
    longer than announced (except a burst of a single step). If the device does not coordinate its
    motors, the burst is also short enough for its deviation.
    """
    left = 1.0 - done
    busiest = max(map(abs, leg.steps(context.core.transmission)))
    takes_s = true_duration_s(context, busiest, leg.duration_s)
    count = max(math.ceil(takes_s * left / burst_s - 1e-9), 1)
    while count < MOST_BURSTS:
        share = left / count
        target = leg.start.towards(leg.end, done + share).motors(context.core.transmission)
        steps = (target - context.core.position.acknowledged).largest
        duration_s = leg.duration_s * share
        short = steps <= 1 or true_duration_s(context, steps, duration_s) <= burst_s
        if short and has_room(context.core, target, _rate_hz(steps, duration_s)):
            return share
        # grow the count by a few percent at a time: an exact search would take too long
        count += 1 + count // (10 if short else 50)
    raise WrongState(NOT_THERE.format("it is off the path"))


def true_duration_s(context: MotionContext, steps: float, duration_s: float) -> float:
    """Return how long the device takes for steps that should take at least `duration_s`."""
    return context.core.controller.duration_s(steps, _rate_hz(steps, duration_s))


def paced_move(
    context: MotionContext,
    there: ArmCoordinates,
    duration_s: float,
    released: Callable[[], bool] = never,
) -> TaskBody[None]:
    """Send one burst that takes at least `duration_s`, unless `released()` is true beforehand.

    If the device's slowest speed is too fast, wait for the rest of the time.
    """
    target = there.motors(context.core.transmission)
    steps = (target - context.core.position.acknowledged).largest
    rate_hz, until_s = _rate_hz(steps, duration_s), context.now_s + duration_s
    yield from context.move(target, rate_hz, there, released)
    slowest_hz = context.core.controller.usable_rate_hz(0.0)
    if steps / slowest_hz < duration_s:
        yield SleepUntil(until_s)


def _rate_hz(steps: float, duration_s: float) -> float:
    return steps / duration_s if duration_s > 0.0 else math.inf


def bench_move(
    context: MotionContext, speeds: SpeedLimits, steps: Motors, fraction: float
) -> TaskBody[Moved]:
    """Move motors by raw steps, in bursts of jogging length, without limits and guards."""
    core = context.core
    began_s, before = context.now_s, context.engine.requests_sent
    with in_motion(context, or_homing=True):
        yield from context.look_before_motion()
        target = core.position.acknowledged + steps
        start, goal = core.position.coordinates, core.position.coordinates_of(target)
        leg = MotionSegment(start, goal, speeds.duration_s(start, goal, fraction))
        yield from drive_legs(context, (leg,), core.config.motion.jog_burst_s)
        yield from context.verify()
    if context.stopping and core.position.acknowledged != target:
        raise context.stopped("the motion was stopped before its goal")
    return report(context, goal, began_s, before)
