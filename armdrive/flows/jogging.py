"""Jogging: short bursts while somebody holds a jog, single increments, and where both end.

A held jog expires by itself: its owner renews it, and the last burst begins before it expires. An
increment expires as well where something keeps it from beginning. Limits and guards are met by
stopping at them, not by an error; moving away from one that is already passed is always allowed.
While the position is unknown, joints may be jogged slowly and without limits, since nothing is
known that they could be compared with.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.errors import ArmError
from armdrive.flow import Flow
from armdrive.flows.held import held_burst, is_held, tell
from armdrive.flows.jog_aims import capped, check_jog, course_of, require_audit
from armdrive.flows.motion import begin, drive_legs
from armdrive.jog_strides import stride
from armdrive.status import State
from kinematics import Joints, KinematicsError, Pose

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.flows.exchange import Wire
    from armdrive.intents import Nudge
    from armdrive.legs import Speeds

PAUSED = "the jog was ended: the arm is paused"
TOO_LATE = "an increment of the jog had to wait for too long and was dropped"


@dataclass(frozen=True, slots=True)
class Jogged:
    """What a jog did; `note` says why it went less far than asked, where it did."""

    joints: Joints
    pose: Pose
    note: str = ""


def jog_session(wire: Wire, speeds: Speeds) -> Flow[Jogged]:
    """Serve increments and the held jog until neither is left, or somebody stops."""
    core = wire.core
    homing = core.state is State.HOMING
    core.notice = ""
    try:
        if not homing:
            begin(wire)
        yield from wire.look_before_motion()
        yield from _serve(wire, speeds)
        if wire.stopping:
            yield from wire.verify()
            core.notice = "the jog was stopped"
    finally:
        core.hold = None
        core.nudges.clear()
        if not homing:
            core.settle()
        core.still_since_s = wire.now_s
    joints, _ = core.transmission.to_joints(core.acknowledged)
    return Jogged(joints, core.config.model.arm.fk(joints), core.notice)


def _serve(wire: Wire, speeds: Speeds) -> Flow[None]:
    core, course = wire.core, course_of(wire.core, speeds)
    while not wire.stopping:
        if core.tempo.paused:
            _give_up(core)
        if core.nudges:
            course.stand()
            yield from _increment(wire, speeds, core.nudges.pop(0))
        elif not (is_held(wire) and (yield from held_burst(wire, course))):
            yield from wire.verify()  # more may be asked for while this is on the wire
            if not core.nudges and not is_held(wire):
                return


def _give_up(core: Core) -> None:
    """Forget the jogs of a paused arm: when it is resumed, nobody expects them any more."""
    if core.nudges or core.hold is not None:
        core.notice = PAUSED
    core.hold = None
    core.nudges.clear()


def _increment(wire: Wire, speeds: Speeds, nudge: Nudge) -> Flow[None]:
    """Move by fixed distances, in bursts of jogging length, as far as the bounds allow.

    A hold that comes meanwhile is what is meant from then on, and letting go of it ends both.
    """
    core = wire.core
    if wire.now_s > nudge.until_s:
        core.notice = TOO_LATE
        return
    speed, known = capped(core, nudge.speed), core.position_known
    try:
        check_jog(core, nudge.jog)
        found = stride(core.config, speeds, nudge.jog, speed, core.coordinates, known=known)
        require_audit(core, *found.legs)
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        return
    tell(wire, found.ended)
    if found.legs:
        over = _overtaken(wire, core.holds)
        yield from drive_legs(wire, found.legs, core.config.motion.jog_burst_s, let_go=over)
        if core.tempo.paused and core.coordinates != found.legs[-1].end:
            core.notice = PAUSED


def _overtaken(wire: Wire, holds: int) -> Callable[[], bool]:
    """Return what tells that an increment's rest is given up, for a hold that came meanwhile.

    A device that stands between bursts goes over to the hold at once. One that queues drives the
    increment meanwhile, unless that hold is let go before: then the rest of it goes with it.
    """
    core = wire.core
    queued = bool(core.controller.abilities.queued_segments)
    return lambda: core.holds != holds and not (queued and is_held(wire))
