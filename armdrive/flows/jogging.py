"""Jogging: short bursts while somebody holds a jog, single increments, and where both end.

A held jog expires by itself: its owner renews it, and the last burst begins before it expires.
Limits and guards are met by stopping at them, not by an error; moving away from one that is
already passed is always allowed. While the position is unknown, joints may be jogged slowly and
without limits, since nothing is known that they could be compared with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.core import Coordinates
from armdrive.engine import Flow
from armdrive.errors import ArmError, BadRequest, NotReferenced
from armdrive.flows.motion import paced_move, true_duration_s
from armdrive.intents import CARTESIAN_AXES, GRIPPER_AXIS, Jog, Space
from armdrive.planning import audit
from armdrive.states import Event
from armdrive.status import State
from kinematics import Joints, KinematicsError, Pose

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.flows.exchange import Wire
    from armdrive.planning import Speeds

ANGULAR_JOG_RAD_S = math.radians(45.0)
"""Pitch and roll of a Cartesian jog at full speed, before the joints' limits slow it."""


@dataclass(frozen=True, slots=True)
class Jogged:
    """What a jog did; `note` says why it went less far than asked, where it did."""

    joints: Joints
    pose: Pose
    note: str = ""


def check_jog(core: Core, jog: Jog) -> None:
    """Raise for a jog that names no axis of this arm, or needs a position that is not known."""
    joints = core.coordinates.joints.names
    known = (*(joints if jog.space is Space.JOINT else CARTESIAN_AXES), GRIPPER_AXIS)
    for name, _ in jog.axes:
        if name not in known:
            raise BadRequest(
                f"no {jog.space.value} axis is called {name!r}; known are {', '.join(known)}"
            )
    if jog.space is Space.CARTESIAN and not core.position_known:
        raise NotReferenced(
            "jogging in Cartesian space needs a known position, and this one is "
            f"{core.belief.trust.value}: {core.belief.reason}. Jog joint by joint, or reference "
            "the arm first (`armdrive home`)"
        )


def jog_session(wire: Wire, speeds: Speeds) -> Flow[Jogged]:
    """Serve increments and the held jog until neither is left, or somebody stops."""
    core = wire.core
    homing = core.state is State.HOMING
    if not homing:
        core.happen(Event.MOVE)
    core.notice = ""
    try:
        while not wire.stopping:
            if core.nudges:
                jog, speed = core.nudges.pop(0)
                yield from _increment(wire, speeds, jog, speed)
            elif not (_held(wire) and (yield from _held_burst(wire, speeds))):
                yield from wire.verify()  # more may be asked for while this is on the wire
                if not core.nudges and not _held(wire):
                    break
    finally:
        core.hold = None
        core.nudges.clear()
        if not homing:
            core.settle()
        core.still_since_s = wire.now_s
    joints, _ = core.transmission.to_joints(core.acknowledged)
    return Jogged(joints, core.config.model.arm.fk(joints), core.notice)


def _increment(wire: Wire, speeds: Speeds, jog: Jog, speed: float) -> Flow[None]:
    """Move by fixed distances, in bursts of jogging length, as far as the bounds allow."""
    core = wire.core
    start = core.coordinates
    try:
        goal = _allowed(core, start, displaced(core, start, jog, 1.0))
    except (ArmError, KinematicsError) as refusal:
        core.notice = str(refusal)
        return
    duration_s = speeds.duration_s(start, goal, _capped(core, speed))
    bursts = _bursts(wire, start, goal, duration_s)
    for index in range(1, bursts + 1):
        if wire.stopping:
            return
        there = start.towards(goal, index / bursts)
        target = core.transmission.to_motors(there.joints, there.opening_mm)
        yield from paced_move(wire, target, duration_s / bursts, there)


def _held(wire: Wire) -> bool:
    hold = wire.core.hold
    return hold is not None and hold.until_s > wire.now_s


def _held_burst(wire: Wire, speeds: Speeds) -> Flow[bool]:
    """Send one burst of the held jog; False where a bound leaves nowhere to go."""
    core = wire.core
    hold = core.hold
    if hold is None:
        return False
    start = core.coordinates
    burst_s = core.config.motion.jog_burst_s
    speed = _capped(core, hold.speed)
    rates = _rates(core, hold.jog, speeds)
    try:
        goal = _allowed(core, start, displaced(core, start, rates, speed * burst_s))
        duration_s = max(speeds.duration_s(start, goal, speed), burst_s)
        bursts = _bursts(wire, start, goal, duration_s)
        if bursts > 1:  # solved anew: a share of the joint motion would leave the straight line
            goal = _allowed(core, start, displaced(core, start, rates, speed * burst_s / bursts))
    except (ArmError, KinematicsError) as refusal:
        core.notice, core.hold = str(refusal), None
        return False
    target = core.transmission.to_motors(goal.joints, goal.opening_mm)
    if goal == start:
        core.hold = None
        return False
    yield from paced_move(wire, target, duration_s / bursts, goal)
    return True


def _bursts(wire: Wire, start: Coordinates, goal: Coordinates, duration_s: float) -> int:
    """Return how many bursts of jogging length a motion needs on a device as slow as feared."""
    if duration_s <= 0.0:
        return 1
    before = wire.core.transmission.to_exact(start.joints, start.opening_mm)
    behind = wire.core.transmission.to_exact(goal.joints, goal.opening_mm)
    busiest = max(abs(b - a) for a, b in zip(before, behind, strict=True))
    takes_s = true_duration_s(wire, busiest, busiest / duration_s)
    return max(math.ceil(takes_s / wire.core.config.motion.jog_burst_s - 1e-9), 1)


def _capped(core: Core, speed: float) -> float:
    """Return the speed, slowed where the position is not known."""
    return speed if core.position_known else min(speed, core.config.motion.unreferenced_speed)


def _rates(core: Core, jog: Jog, speeds: Speeds) -> Jog:
    """Turn directions from -1 to 1 into degrees and mm a second at full speed."""
    full = dict(
        zip(core.coordinates.joints.names, map(math.degrees, speeds.joints_rad_s), strict=True)
    )
    if jog.space is Space.CARTESIAN:
        tip_mm_s = core.config.motion.tip_speed_mm_s
        full = dict.fromkeys(("x", "y", "z"), tip_mm_s)
        full |= dict.fromkeys(("pitch", "roll"), math.degrees(ANGULAR_JOG_RAD_S))
    full[GRIPPER_AXIS] = speeds.gripper_mm_s
    return Jog(jog.space, tuple((name, share * full[name]) for name, share in jog.axes))


def displaced(core: Core, start: Coordinates, jog: Jog, factor: float) -> Coordinates:
    """Return the point that a jog leads to; raises where no posture reaches it."""
    opening_mm = start.opening_mm + jog.amount(GRIPPER_AXIS) * factor
    if jog.space is Space.JOINT:
        angles = (
            angle + math.radians(jog.amount(name) * factor)
            for name, angle in zip(start.joints.names, start.joints, strict=True)
        )
        return Coordinates(Joints(tuple(angles), start.joints.names), opening_mm)
    if all(name == GRIPPER_AXIS for name, _ in jog.axes):
        return Coordinates(start.joints, opening_mm)
    arm = core.config.model.arm
    pose = arm.fk(start.joints)
    x, y, z, pitch, roll = (jog.amount(name) * factor for name in CARTESIAN_AXES)
    goal = Pose(
        pose.x_mm + x,
        pose.y_mm + y,
        pose.z_mm + z,
        pose.pitch_rad + math.radians(pitch),
        pose.roll_rad + math.radians(roll),
    )
    return Coordinates(arm.ik(goal, start.joints), opening_mm)


def _allowed(core: Core, start: Coordinates, goal: Coordinates) -> Coordinates:
    """Return the goal, drawn back to the joint limits and the gripper's range; guards refuse."""
    if not core.position_known:
        return goal
    clipped = Coordinates(_within_limits(core, start, goal), _within_range(core, start, goal))
    audit(core.config, [start.joints, clipped.joints])
    if clipped != goal:
        core.notice = _clip_note(goal, clipped)
    return clipped


def _within_limits(core: Core, start: Coordinates, goal: Coordinates) -> Joints:
    angles = []
    for bounds, here, there in zip(
        core.config.model.arm.limits, start.joints, goal.joints, strict=True
    ):
        low, high = min(bounds.low_rad, here), max(bounds.high_rad, here)
        angles.append(min(max(there, low), high))
    return Joints(tuple(angles), goal.joints.names)


def _within_range(core: Core, start: Coordinates, goal: Coordinates) -> float:
    low, high = core.config.model.gripper_range_mm
    low, high = min(low, start.opening_mm), max(high, start.opening_mm)
    return min(max(goal.opening_mm, low), high)


def _clip_note(goal: Coordinates, clipped: Coordinates) -> str:
    at_limit = [
        name
        for name, wanted, got in zip(goal.joints.names, goal.joints, clipped.joints, strict=True)
        if wanted != got
    ]
    if goal.opening_mm != clipped.opening_mm:
        at_limit.append(GRIPPER_AXIS)
    return f"the {' and the '.join(at_limit)} stopped at the limit"
