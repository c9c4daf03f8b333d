"""A held jog: the next leg of its course, decided at the last moment, while it is held."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from armdrive.abilities import Abort, segment_s
from armdrive.errors import ArmError, BadRequest, NotReferenced, WrongState
from armdrive.motion.context import MotionContext, Way
from armdrive.motion.execute import drive_legs, in_motion, next_share, paced_move, stream_held
from armdrive.motion.frames import axes_of
from armdrive.motion.gripper import require_finger_motor
from armdrive.motion.jog.bounds import JogEnded
from armdrive.motion.jog.course import JogCourse, JogProposal, Terms, Wish, stride
from armdrive.motion.jog.rates import axis_names
from armdrive.motion.plan import SpeedLimits, audit
from armdrive.moves import BASE_FRAME, GRIPPER_AXIS, ContinuousJog, IncrementalJog, Jog, Space
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from armdrive.tasks import TaskBody
from kinematics.errors import KinematicsError, suggestion
from kinematics.spaces import Joints, Pose

# What a jog may move, how fast, on which terms: where an arm's state meets its jog's course.


def check_jog(core: Core, jog: Jog) -> None:
    """Raise for a jog that names no axis of this arm, or needs a position that is not known."""
    if core.speed_override.paused:
        raise WrongState("the arm is paused and is not jogged: resume it first (`armdrive resume`)")
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
            "the arm first (`armdrive home`)"
        )


def capped(core: Core, speed: float) -> float:
    """Return the speed, slowed where the position is not known."""
    return speed if core.position_known else min(speed, core.config.motion.unreferenced_speed)


def wish_of(core: Core, hold: ContinuousJog) -> Wish:
    """Return what somebody who holds a jog wants of the arm as it is now. Raises as `check_jog`."""
    check_jog(core, hold.jog)
    speed = capped(core, hold.speed) * core.speed_override.override
    return Wish(hold.jog, speed, known=core.position_known)


def course_of(core: Core, speeds: SpeedLimits) -> JogCourse:
    """Return the course of a jog that begins."""
    queued = bool(core.controller.abilities.queued_segments)
    terms = Terms(core.config.motion.jog_ramp_s, queued, runs_on_s(core))
    return JogCourse(core.config, speeds, terms)


def runs_on_s(core: Core) -> float:
    """Return how long the arm may run on while it stops, where it does not end by itself.

    A device without an abort ends each burst where it was audited to end.
    """
    if core.controller.abilities.abort is Abort.NONE:
        return 0.0
    return core.controller.stopping(core.config.motion.jog_burst_s).asked_motion_s


def require_audit(core: Core, *legs: MotionSegment) -> None:
    """Raise `OutOfBounds` for legs that would pass a limit or a guard: nothing goes unaudited."""
    if core.position_known and legs:
        audit(core.config, [legs[0].start.joints, *(leg.end.joints for leg in legs)])


SHORTER_TRIES = 3
"""How often a line's burst is solved anew: by then a share of its joint motion is as straight."""


def is_held(wire: MotionContext) -> bool:
    """Tell whether somebody holds a jog now."""
    hold = wire.core.hold
    return hold is not None and hold.until_s > wire.now_s and not wire.core.speed_override.paused


def held_burst(wire: MotionContext, course: JogCourse) -> TaskBody[bool]:
    """Go on with the held jog for a burst; False where a bound leaves nowhere to go.

    A device that queues segments is driven for as long as the jog is held.
    """
    core = wire.core
    if core.controller.abilities.queued_segments:
        held = _Held(wire, course)
        ahead_s = core.config.motion.jog_burst_s
        let_go = lambda: not is_held(wire) or bool(core.nudges)  # noqa: E731
        yield from stream_held(wire, held.ways(), ahead_s, let_go)
        held.end()
        return is_held(wire)
    hold = core.hold
    found = None if hold is None else _fitting(wire, course, hold)
    if found is None:
        return False
    course.take(found, wire.now_s)
    leg = found.leg
    yield from paced_move(wire, leg.end, leg.duration_s, lambda: not is_held(wire))
    return True


class _Held:
    """The points of a held jog that is queued, and the hold that has led to a bound.

    What leads to the bound is driven to its end, so that the hold is given up only behind it.
    """

    def __init__(self, wire: MotionContext, course: JogCourse) -> None:
        self._wire = wire
        self._course = course
        self._ended: ContinuousJog | None = None

    def ways(self) -> Iterator[Way]:
        """Give points, each from where the one before has led."""
        wire, core = self._wire, self._wire.core
        here = core.position.coordinates
        part_s = segment_s(core.config.motion.jog_burst_s)
        while not wire.stopping and is_held(wire) and core.hold is not None:
            hold = core.hold
            found = _proposed(wire, self._course, hold, here, part_s)
            if found is None:
                self._ended = hold
                return
            self._course.take(found, wire.now_s)
            here = found.leg.end
            yield here, found.leg.duration_s

    def end(self) -> None:
        """Give up the hold that led to a bound, unless somebody holds another by now."""
        self._course.stand()
        if self._ended is not None:
            _give_up(self._wire, self._ended)


def _fitting(wire: MotionContext, course: JogCourse, hold: ContinuousJog) -> JogProposal | None:
    """Return a leg that this device ends within a burst; None where the jog ends here.

    A long line that takes too long is asked for anew, for a shorter time: a share of its joint
    motion would not be straight.
    """
    core, tries = wire.core, SHORTER_TRIES
    longest_s = time_s = core.config.motion.jog_burst_s
    while (found := _proposed(wire, course, hold, core.position.coordinates, time_s)) is not None:
        share, tries = next_share(wire, found.leg, longest_s, 0.0), tries - 1
        if share >= 1.0 or not tries or hold.jog.space is Space.JOINT:
            return found.shortened(share)
        time_s *= share
    _give_up(wire, hold)
    return None


def _proposed(
    wire: MotionContext,
    course: JogCourse,
    hold: ContinuousJog,
    start: ArmCoordinates,
    time_s: float,
) -> JogProposal | None:
    """Return the next leg of the held jog; None where it ends, with the reason as the notice."""
    core = wire.core
    try:
        found = course.propose(wish_of(core, hold), start, time_s, wire.now_s)
        if isinstance(found, JogEnded):
            tell(wire, found)
            course.note = found.note
            return None
        require_audit(core, found.leg)
    except (ArmError, KinematicsError) as refusal:
        core.diagnostics.notify(str(refusal), refusal)
        return None
    if found.note != course.note:  # also of nothing any more, as when it leads back
        core.diagnostics.notice = course.note = found.note
    return found


def tell(wire: MotionContext, ended: JogEnded) -> None:
    """Have the status say why a jog has ended, where there is a reason."""
    if ended.cause is not None:
        wire.core.diagnostics.notify(ended.note, ended.cause)
    elif ended.note:
        wire.core.diagnostics.notice = ended.note


def _give_up(wire: MotionContext, hold: ContinuousJog) -> None:
    """Forget a hold and its renewals, but not another that somebody has begun meanwhile."""
    now = wire.core.hold
    if now is not None and now.jog == hold.jog:
        wire.core.hold = None


# Jogging: short bursts while somebody holds a jog, single increments, and where both end.
#
# A held jog expires by itself: its owner renews it, and the last burst begins before it expires. An
# increment expires as well where something keeps it from beginning. Limits and guards are met by
# stopping at them, not by an error; moving away from one that is already passed is always allowed.
# While the position is unknown, joints may be jogged slowly and without limits, since nothing is
# known that they could be compared with.

PAUSED = "the jog was ended: the arm is paused"
TOO_LATE = "an increment of the jog had to wait for too long and was dropped"


@dataclass(frozen=True, slots=True)
class Jogged:
    """What a jog did; `note` says why it went less far than asked, where it did."""

    joints: Joints
    pose: Pose
    note: str = ""


def jog_session(wire: MotionContext, speeds: SpeedLimits) -> TaskBody[Jogged]:
    """Serve increments and the held jog until neither is left, or somebody stops."""
    core = wire.core
    core.diagnostics.notice = ""
    try:
        with in_motion(wire, or_homing=True):
            yield from wire.look_before_motion()
            yield from _serve(wire, speeds)
            if wire.stopping:
                yield from wire.verify()
                core.diagnostics.notice = "the jog was stopped"
    finally:
        core.hold = None
        core.nudges.clear()
    joints, _ = core.transmission.to_joints(core.position.acknowledged)
    return Jogged(joints, core.config.model.arm.fk(joints), core.diagnostics.notice)


def _serve(wire: MotionContext, speeds: SpeedLimits) -> TaskBody[None]:
    core, course = wire.core, course_of(wire.core, speeds)
    while not wire.stopping:
        if core.speed_override.paused:
            _give_up_paused(core)
        if core.nudges:
            course.stand()
            yield from _increment(wire, speeds, core.nudges.pop(0))
        elif not (is_held(wire) and (yield from held_burst(wire, course))):
            yield from wire.verify()  # more may be asked for while this is on the wire
            if not core.nudges and not is_held(wire):
                return


def _give_up_paused(core: Core) -> None:
    """Forget the jogs of a paused arm: when it is resumed, nobody expects them any more."""
    if core.nudges or core.hold is not None:
        core.diagnostics.notice = PAUSED
    core.hold = None
    core.nudges.clear()


def _increment(wire: MotionContext, speeds: SpeedLimits, nudge: IncrementalJog) -> TaskBody[None]:
    """Move by fixed distances, in bursts of jogging length, as far as the bounds allow.

    A hold that comes meanwhile is what is meant from then on, and letting go of it ends both.
    """
    core = wire.core
    if wire.now_s > nudge.until_s:
        core.diagnostics.notice = TOO_LATE
        return
    speed, known = capped(core, nudge.speed), core.position_known
    try:
        check_jog(core, nudge.jog)
        found = stride(
            core.config, speeds, nudge.jog, speed, core.position.coordinates, known=known
        )
        require_audit(core, *found.legs)
    except (ArmError, KinematicsError) as refusal:
        core.diagnostics.notify(str(refusal), refusal)
        return
    tell(wire, found.ended)
    if found.legs:
        over = _overtaken(wire, core.holds)
        yield from drive_legs(wire, found.legs, core.config.motion.jog_burst_s, let_go=over)
        if core.speed_override.paused and core.position.coordinates != found.legs[-1].end:
            core.diagnostics.notice = PAUSED


def _overtaken(wire: MotionContext, holds: int) -> Callable[[], bool]:
    """Return what tells that an increment's rest is given up, for a hold that came meanwhile.

    A device that stands between bursts goes over to the hold at once. One that queues drives the
    increment meanwhile, unless that hold is let go before: then the rest of it goes with it.
    """
    core = wire.core
    queued = bool(core.controller.abilities.queued_segments)
    return lambda: core.holds != holds and not (queued and is_held(wire))
