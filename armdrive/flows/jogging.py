"""Jogging: short bursts while somebody holds a jog, single increments, and where both end.

A held jog expires by itself: its owner renews it, and the last burst begins before it expires.
Limits and guards are met by stopping at them, not by an error; moving away from one that is
already passed is always allowed. While the position is unknown, joints may be jogged slowly and
without limits, since nothing is known that they could be compared with.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.engine import Flow
from armdrive.errors import ArmError
from armdrive.flows.held import held_burst, is_held
from armdrive.flows.jog_aims import allowed, capped, check_jog, displaced
from armdrive.flows.motion import begin, drive_legs
from armdrive.intents import Jog
from armdrive.planning import Leg
from armdrive.status import State
from kinematics import Joints, KinematicsError, Pose

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.flows.exchange import Wire
    from armdrive.planning import Speeds

PAUSED = "the jog was ended: the arm is paused"


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
    core = wire.core
    while not wire.stopping:
        if core.tempo.paused:
            _give_up(core)
        if core.nudges:
            jog, speed = core.nudges.pop(0)
            yield from _increment(wire, speeds, jog, speed)
        elif not (is_held(wire) and (yield from held_burst(wire, speeds))):
            yield from wire.verify()  # more may be asked for while this is on the wire
            if not core.nudges and not is_held(wire):
                return


def _give_up(core: Core) -> None:
    """Forget the jogs of a paused arm: when it is resumed, nobody expects them any more."""
    if core.nudges or core.hold is not None:
        core.notice = PAUSED
    core.hold = None
    core.nudges.clear()


def _increment(wire: Wire, speeds: Speeds, jog: Jog, speed: float) -> Flow[None]:
    """Move by fixed distances, in bursts of jogging length, as far as the bounds allow."""
    core = wire.core
    start = core.coordinates
    try:
        check_jog(core, jog)
        goal = allowed(core, start, displaced(core, start, jog, 1.0))
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        return
    leg = Leg(start, goal, speeds.duration_s(start, goal, capped(core, speed)))
    if start != goal:
        yield from drive_legs(wire, (leg,), core.config.motion.jog_burst_s, jog=True)
        if core.tempo.paused and core.coordinates != goal:
            core.notice = PAUSED
