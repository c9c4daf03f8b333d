"""Jog sessions: serving increments and a held jog until both have ended.

This file decides who may jog (`require_allowed`) and how fast while the position is unknown
(`capped`), and runs the session. Each leg of a held jog is decided by

    course   the next leg, or why the jog ends: the ramp, braking before bounds, what joints and
             motors can reach; also the legs of an increment
    bounds   the axes and the path of a jog, and how far it may go: limits, guards, postures

How long a hold lasts without being renewed is in `arm.jogging`, for keys in `motion.dead_man`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from armdrive.abilities import Abort, segment_s
from armdrive.errors import (
    ArmError,
    BadRequest,
    NotReferenced,
    OutOfBounds,
    Refused,
    WrongState,
)
from armdrive.motion.context import MotionContext, StreamedCourse, Way
from armdrive.motion.execute import drive_legs, in_motion, next_share, paced_move
from armdrive.motion.frames import axes_of
from armdrive.motion.gripper import require_finger_motor
from armdrive.motion.jog.bounds import JogEnded, axis_names, full_speeds
from armdrive.motion.jog.course import (
    JogCourse,
    JogIncrement,
    JogProposal,
    Wish,
    amounts_of,
    stride,
)
from armdrive.motion.plan import SpeedLimits, audit
from armdrive.moves import BASE_FRAME, GRIPPER_AXIS, ContinuousJog, IncrementalJog, Jog, Space
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from armdrive.tasks import MoveAlong, SleepUntil, TaskBody
from kinematics.errors import KinematicsError, suggestion
from kinematics.limits import LIMIT_TOLERANCE_RAD
from kinematics.spaces import Joints, Pose
from kinematics.text import shown_name

# What a jog may do, given the state of the arm.


def check_jog(core: Core, jog: Jog) -> None:
    """Raise for an axis that the arm does not have, and for a jog that needs a known position."""
    if core.speed_override.paused:
        raise WrongState(
            "a paused arm is not jogged: call `resume()`, or run `armdrive resume` in another "
            "terminal"
        )
    known = axis_names(core.config, jog.space)
    for name, _ in jog.axes:
        if name not in known:
            raise BadRequest(
                f"no {jog.space.value} axis is called {name!r}; known are {', '.join(known)}"
                f"{suggestion(name, known)}"
            )
    if jog.amount(GRIPPER_AXIS):
        require_finger_motor(core)
    if jog.space is Space.CARTESIAN:
        core.require_geometry()
    if jog.frame != BASE_FRAME:
        axes_of(core.config, core.position.coordinates.joints, jog.frame)
    if jog.space is Space.CARTESIAN and not core.position_known:
        raise NotReferenced(
            "jogging in Cartesian space needs a known position, and this one is "
            f"{core.belief.trust.value}: {core.belief.reason}. Jog joint by joint, or reference "
            "the arm first (`home()`)"
        )


def check_increment(core: Core, jog: Jog) -> None:
    """Raise like `check_jog`, and for an increment longer than the whole range of its axis."""
    check_jog(core, jog)
    _require_range(core, jog, amounts_of(core.config, jog))


def require_allowed(core: Core, asked: ContinuousJog | IncrementalJog) -> None:
    """Raise unless a jog that was asked for may begin or go on: called before each of its legs.

    Raises like `check_jog` or `check_increment`, and `NotReferenced` for a jog that was asked for
    with limits and would now have none.
    """
    if asked.bounded and not core.position_known:
        raise NotReferenced(
            f"the jog has ended, because the position is {core.belief.trust.value} now "
            f"({core.belief.reason}): no limit would stop it. Let go, then jog again, slowly and "
            "without limits, or reference the arm (`home()`)"
        )
    if isinstance(asked, IncrementalJog):
        check_increment(core, asked.jog)
    else:
        check_jog(core, asked.jog)


def check_duration(core: Core, speeds: SpeedLimits, hold: ContinuousJog, duration_s: float) -> None:
    """Raise for a held jog that would take an axis further than its whole range."""
    full = full_speeds(core.config, speeds, hold.jog.space)
    shares = (hold.jog.amount(name) for name in axis_names(core.config, hold.jog.space))
    longest_s = capped(core, hold.speed) * duration_s
    _require_range(core, hold.jog, [a * b * longest_s for a, b in zip(shares, full, strict=True)])


def _require_range(core: Core, jog: Jog, amounts: Sequence[float]) -> None:
    """Raise `OutOfBounds` for more than the whole range of an axis if no limit ends the jog.

    A jog is cut off at the limits, which needs a known position. Without one, such an amount is
    wrong wherever the arm stands.
    """
    if core.position_known or jog.space is not Space.JOINT:
        return
    *_, gripper = names = axis_names(core.config, jog.space)
    ranges = [(one.low_rad, one.high_rad) for one in core.config.model.arm.limits]
    ranges.append(core.config.model.gripper_range_mm)
    for name, amount, (low, high) in zip(names, amounts, ranges, strict=True):
        if abs(amount) <= high - low + LIMIT_TOLERANCE_RAD:
            continue
        asked, whole, unit = amount, high - low, " mm"
        if name != gripper:
            asked, whole, unit = math.degrees(asked), math.degrees(whole), "°"
        raise OutOfBounds(
            f"the {shown_name(name)} would move by {asked:g}{unit}, but its whole range is "
            f"{whole:g}{unit}, and no limit can end the jog because the position is "
            f"{core.belief.trust.value}: jog by less, or reference the arm first (`home()`)",
            name=name,
            value=asked,
            bound=whole,
        )


def capped(core: Core, speed: float) -> float:
    """Return the speed, limited if the position is not known."""
    return speed if core.position_known else min(speed, core.config.motion.unreferenced_speed)


def wish_of(core: Core, hold: ContinuousJog) -> Wish:
    """Return the wish of a held jog, for the present state of the arm.

    Raises like `require_allowed`.
    """
    require_allowed(core, hold)
    speed = capped(core, hold.speed) * core.speed_override.override
    return Wish(hold.jog, speed, core.position_known)


def course_of(core: Core, speeds: SpeedLimits) -> JogCourse:
    """Return the course of a new jog."""
    queued = bool(core.controller.abilities.queued_segments)
    return JogCourse(core.config, speeds, queued=queued, run_on_s=runs_on_s(core))


def runs_on_s(core: Core) -> float:
    """Return how long the arm may run on after a stop.

    A device without an abort ends each burst at its audited target, so it does not run on.
    """
    if core.controller.abilities.abort is Abort.NONE:
        return 0.0
    return core.controller.stopping(core.config.motion.jog_burst_s).asked_motion_s


def require_audit(core: Core, *legs: MotionSegment) -> None:
    """Raise `OutOfBounds` for legs that would violate a limit or a guard: all motion is audited."""
    if core.position_known and legs:
        audit(core.config, [legs[0].start.joints, *(leg.end.joints for leg in legs)])


SHORTER_TRIES = 3  # attempts to shorten a line's burst by solving it again; then cut it in joints


def is_held(context: MotionContext) -> bool:
    """Return whether a jog is being held."""
    hold = context.core.hold
    return (
        hold is not None and hold.until_s > context.now_s and not context.core.speed_override.paused
    )


def held_burst(context: MotionContext, course: JogCourse) -> TaskBody[bool]:
    """Drive the held jog for a burst; return False if a bound has ended it."""
    hold = context.core.hold
    found = None if hold is None else _fitting(context, course, hold)
    if found is None:
        return False
    course.take(found)
    leg = found.leg
    yield from paced_move(context, leg.end, leg.duration_s, lambda: not is_held(context))
    return True


def held_stream(context: MotionContext, course: JogCourse) -> TaskBody[bool]:
    """Drive the held jog on a device with a queue, for as long as it is held.

    Return False if it is not held any more. The motion up to a bound is driven to its end before
    the hold is dropped.
    """
    core = context.core
    ahead_s = core.config.motion.jog_burst_s
    ended: ContinuousJog | None = None

    def ways() -> Iterator[Way]:
        """Yield points, each computed from the previous one."""
        nonlocal ended
        here, part_s = core.position.coordinates, segment_s(ahead_s)
        while not context.stopping and is_held(context) and (hold := core.hold) is not None:
            found = _proposed(context, course, hold, here, part_s)
            if found is None:
                ended = hold
                return
            course.take(found)
            here = found.leg.end
            yield here, found.leg.duration_s

    def released() -> bool:
        return not is_held(context) or bool(core.nudges)

    streamed = StreamedCourse(core, ways())
    yield from context.stream(
        MoveAlong(streamed.segments(), ahead_s, jog=True, released=released), streamed
    )
    course.stand()
    if streamed.still_s:
        yield SleepUntil(context.now_s + streamed.still_s)
    if ended is not None:
        _give_up(context, ended)
    return is_held(context)


def _fitting(context: MotionContext, course: JogCourse, hold: ContinuousJog) -> JogProposal | None:
    """Return a leg that the device completes within a burst; None if the jog ends here.

    If a line takes too long, it is solved again for a shorter time, because a share of its joint
    motion would not be straight.
    """
    core, tries = context.core, SHORTER_TRIES
    longest_s = time_s = core.config.motion.jog_burst_s
    while (
        found := _proposed(context, course, hold, core.position.coordinates, time_s)
    ) is not None:
        share, tries = next_share(context, found.leg, longest_s, 0.0), tries - 1
        if share >= 1.0 or not tries or hold.jog.space is Space.JOINT:
            return found.shortened(share)
        time_s *= share
    _give_up(context, hold)
    return None


def _proposed(
    context: MotionContext,
    course: JogCourse,
    hold: ContinuousJog,
    start: ArmCoordinates,
    time_s: float,
) -> JogProposal | None:
    """Return the next leg of the held jog; None if it ends, with the reason in the notice."""
    core = context.core
    try:
        found = course.propose(wish_of(core, hold), start, time_s)
        if isinstance(found, JogEnded):
            show_end(context, found)
            course.note = found.note
            return None
        require_audit(core, found.leg)
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        return None
    if found.note != course.note:  # also if the note disappears, as when the jog turns back
        course.note = found.note
        core.notify(found.note)
    return found


def show_end(context: MotionContext, ended: JogEnded) -> None:
    """Show in the notice why a jog has ended, if there is a reason."""
    if ended.cause is not None:
        context.core.notify(ended.note, ended.cause)
    elif ended.note:
        context.core.notify(ended.note)


def _give_up(context: MotionContext, hold: ContinuousJog) -> None:
    """Drop a hold and its renewals, but not another hold that has replaced it."""
    now = context.core.hold
    if now is not None and now.jog == hold.jog:
        context.core.hold = None


# The session.
#
# A held jog expires unless its owner renews it; its last burst begins before it expires. An
# increment expires too if it cannot begin in time. A jog stops at limits and guards without an
# error, and moving away from a bound that has been passed is always allowed. While the position is
# unknown, joints may be jogged slowly and without limits. A jog that was asked for with limits ends
# if the position is no longer known.

PAUSED = "the jog has ended because the arm is paused"
TOO_LATE = "a jog increment was dropped because it had to wait too long"


@dataclass(frozen=True, slots=True)
class Jogged:
    """The result of a jog; `note` says why it ended early, if it did."""

    joints: Joints
    pose: Pose
    note: str = ""


def jog_session(context: MotionContext, speeds: SpeedLimits) -> TaskBody[Jogged]:
    """Serve increments and the held jog until neither is left. A stop raises `Stopped`."""
    core = context.core
    try:
        with in_motion(context, or_homing=True):
            yield from context.look_before_motion()
            yield from _serve(context, speeds)
            if context.stopping:
                yield from context.verify()
                core.notify(str(context.stopped("the jog was stopped")))
    except Refused as refusal:  # a key waits for no result
        core.notify(str(refusal), refusal)
        raise
    finally:
        core.hold = None
        core.nudges.clear()
    if context.stopping:
        raise context.stopped("the jog was stopped")
    joints, _ = core.transmission.to_joints(core.position.acknowledged)
    return Jogged(joints, core.config.model.arm.fk(joints), core.notice.words)


def _serve(context: MotionContext, speeds: SpeedLimits) -> TaskBody[None]:
    core, course = context.core, course_of(context.core, speeds)
    held = held_stream if core.controller.abilities.queued_segments else held_burst
    while not context.stopping:
        if core.speed_override.paused:
            _give_up_paused(core)
        if core.nudges:  # before the hold: an increment is what the key asked for first
            course.stand()
            yield from _increment(context, speeds, core.nudges.pop(0))
        elif not (is_held(context) and (yield from held(context, course))):
            yield from context.verify()  # another jog may be requested meanwhile
            if not core.nudges and not is_held(context):
                return


def _give_up_paused(core: Core) -> None:
    """Drop the jogs of a paused arm: after a resume, the operator no longer expects them."""
    if core.nudges or core.hold is not None:
        core.notify(PAUSED)
    core.hold = None
    core.nudges.clear()


def _strides(core: Core, speeds: SpeedLimits, jog: Jog, speed: float) -> JogIncrement:
    """Return the legs of an increment from where the arm stands."""
    start, known = core.position.coordinates, core.position_known
    return stride(core.config, speeds, jog, capped(core, speed), start, known=known)


def increment_s(core: Core, speeds: SpeedLimits, jog: Jog, speed: float) -> float:
    """Return how long an increment lasts from where the arm stands, as far as bounds allow."""
    return math.fsum(leg.duration_s for leg in _strides(core, speeds, jog, speed).legs)


def _increment(
    context: MotionContext, speeds: SpeedLimits, nudge: IncrementalJog
) -> TaskBody[None]:
    """Move by a fixed distance, in bursts of jogging length, as far as the bounds allow.

    A hold that begins meanwhile replaces the increment, and releasing it ends both.
    """
    core = context.core
    if context.now_s > nudge.until_s:
        core.notify(TOO_LATE)
        return
    try:
        require_allowed(core, nudge)
        found = _strides(core, speeds, nudge.jog, nudge.speed)
        require_audit(core, *found.legs)
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        return
    show_end(context, found.ended)
    if found.legs:
        over = _overtaken(context, nudge.holds)
        yield from drive_legs(context, found.legs, core.config.motion.jog_burst_s, released=over)
        if core.speed_override.paused and core.position.coordinates != found.legs[-1].end:
            core.notify(PAUSED)


def _overtaken(context: MotionContext, holds: int) -> Callable[[], bool]:
    """Return a test whether the rest of an increment is dropped in favour of a new hold.

    Without a queue, the device changes to the hold at once. With a queue, it finishes the increment
    while the hold lasts; releasing the hold drops the rest.
    """
    core = context.core
    queued = bool(core.controller.abilities.queued_segments)
    return lambda: core.holds != holds and not (queued and is_held(context))
