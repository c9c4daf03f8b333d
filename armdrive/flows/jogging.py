"""Jogging: short bursts while somebody holds a jog, single increments, and where both end.

A held jog expires by itself: its owner renews it, and the last burst begins before it expires.
Limits and guards are met by stopping at them, not by an error; moving away from one that is
already passed is always allowed. While the position is unknown, joints may be jogged slowly and
without limits, since nothing is known that they could be compared with.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.abilities import Abort
from armdrive.core import Coordinates
from armdrive.engine import Flow
from armdrive.errors import ArmError, BadRequest, NotReferenced, Refused, WrongState
from armdrive.flows.gripping import require_finger_motor
from armdrive.flows.motion import begin, drive_legs, next_share, paced_move
from armdrive.flows.streaming import SEGMENTS_AHEAD, Way, stream_held
from armdrive.intents import CARTESIAN_AXES, GRIPPER_AXIS, YAW_AXIS, Jog, Space
from armdrive.planning import Leg, audit
from armdrive.status import State
from kinematics import Joints, KinematicsError, Pose

if TYPE_CHECKING:
    from armdrive.core import Core, Hold
    from armdrive.flows.exchange import Wire
    from armdrive.planning import Speeds

ANGULAR_JOG_RAD_S = math.radians(45.0)
"""Pitch and roll of a Cartesian jog at full speed, before the joints' limits slow it."""

NEARLY = 1e-3
"""So much longer than it should be a leg may last before it is solved anew."""

PAUSED = "the jog was ended: the arm is paused"

SHORTER_TRIES = 8
"""How often a held burst is made shorter before it is given up."""


@dataclass(frozen=True, slots=True)
class Jogged:
    """What a jog did; `note` says why it went less far than asked, where it did."""

    joints: Joints
    pose: Pose
    note: str = ""


def check_jog(core: Core, jog: Jog) -> None:
    """Raise for a jog that names no axis of this arm, or needs a position that is not known."""
    if core.tempo.paused:
        raise WrongState("the arm is paused and is not jogged: resume it first (`armdrive resume`)")
    joints = core.coordinates.joints.names
    known = (*(joints if jog.space is Space.JOINT else cartesian_axes(core)), GRIPPER_AXIS)
    for name, _ in jog.axes:
        if name not in known:
            raise BadRequest(
                f"no {jog.space.value} axis is called {name!r}; known are {', '.join(known)}"
            )
    if jog.amount(GRIPPER_AXIS):
        require_finger_motor(core)
    if jog.space is Space.CARTESIAN:
        core.require_geometry()
    if jog.space is Space.CARTESIAN and not core.position_known:
        raise NotReferenced(
            "jogging in Cartesian space needs a known position, and this one is "
            f"{core.belief.trust.value}: {core.belief.reason}. Jog joint by joint, or reference "
            "the arm first (`armdrive home`)"
        )


def cartesian_axes(core: Core) -> tuple[str, ...]:
    """Return the axes of a Cartesian jog of this arm."""
    return (*CARTESIAN_AXES, YAW_AXIS) if core.config.model.arm.has_yaw else CARTESIAN_AXES


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
        elif not (_held(wire) and (yield from _held_burst(wire, speeds))):
            yield from wire.verify()  # more may be asked for while this is on the wire
            if not core.nudges and not _held(wire):
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
        goal = _allowed(core, start, displaced(core, start, jog, 1.0))
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        return
    leg = Leg(start, goal, speeds.duration_s(start, goal, _capped(core, speed)))
    if start != goal:
        yield from drive_legs(wire, (leg,), core.config.motion.jog_burst_s, jog=True)
        if core.tempo.paused and core.coordinates != goal:
            core.notice = PAUSED


def _held(wire: Wire) -> bool:
    hold = wire.core.hold
    return hold is not None and hold.until_s > wire.now_s and not wire.core.tempo.paused


def _held_burst(wire: Wire, speeds: Speeds) -> Flow[bool]:
    """Go on with the held jog for a burst; False where a bound leaves nowhere to go.

    A device that queues segments is driven for as long as the jog is held.
    """
    core = wire.core
    if core.controller.abilities.queued_segments:
        ways = _held_ways(wire, speeds)
        ahead_s = core.config.motion.jog_burst_s
        yield from stream_held(wire, ways, ahead_s, lambda: not _held(wire) or bool(core.nudges))
        return _held(wire)
    leg = _next_held(wire, speeds, core.coordinates, core.config.motion.jog_burst_s, _fitting)
    if leg is None:
        return False
    yield from paced_move(wire, leg.end, leg.duration_s, lambda: not _held(wire))
    return True


def _held_ways(wire: Wire, speeds: Speeds) -> Iterator[Way]:
    """Give the points of a held jog, each from where the one before has led."""
    core = wire.core
    here = core.coordinates
    part_s = core.config.motion.jog_burst_s / SEGMENTS_AHEAD
    while not wire.stopping and _held(wire):
        leg = _next_held(wire, speeds, here, part_s, _in_time)
        if leg is None:
            return
        here = leg.end
        yield leg.end, leg.duration_s


Share = Callable[["Wire", Leg, float], float]
"""How much of a leg fits into a burst of so many seconds."""


def _fitting(wire: Wire, leg: Leg, longest_s: float) -> float:
    return next_share(wire, leg, longest_s, 0.0)


def _in_time(_wire: Wire, leg: Leg, longest_s: float) -> float:
    """Of a device that keeps its own time: only the joints' speeds make a leg last longer."""
    return 1.0 if leg.duration_s <= longest_s * (1.0 + NEARLY) else longest_s / leg.duration_s


def _next_held(
    wire: Wire, speeds: Speeds, start: Coordinates, longest_s: float, share_of: Share
) -> Leg | None:
    """Return the next leg of the held jog, None where it ends: let go, or at a bound."""
    core = wire.core
    hold = core.hold
    if hold is None:
        return None
    try:
        check_jog(core, hold.jog)
        leg = _held_leg(wire, speeds, hold, start, longest_s, share_of)
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        core.hold = None
        return None
    if leg.start == leg.end:
        core.hold = None
        return None
    return leg


def _held_leg(
    wire: Wire, speeds: Speeds, hold: Hold, start: Coordinates, longest_s: float, share_of: Share
) -> Leg:
    """Return what one burst covers; near a guard or the edge of the reach, as much as there is.

    A leg that is too long for a burst on this device is solved anew for a shorter time: a share
    of its joint motion would leave the straight line of a Cartesian jog. An arm that runs on
    while it stops goes slower, so that it would stop before a guard.
    """
    core = wire.core
    speed = _capped(core, hold.speed) * core.tempo.override
    rates = _rates(core, hold.jog, speeds)
    burst_s, runs_on_s = longest_s, _runs_on_s(core)
    refused: ArmError | KinematicsError | None = None
    for _ in range(SHORTER_TRIES):
        try:
            there = displaced(core, start, rates, speed * burst_s)
            goal = _allowed(core, start, there, runs_on_s / burst_s)
        except (ArmError, KinematicsError) as refusal:
            refused = refused or refusal
            if runs_on_s > 0.0:
                speed /= 2.0
            else:
                burst_s /= 2.0
            continue
        leg = Leg(start, goal, max(speeds.duration_s(start, goal, speed), burst_s))
        share = share_of(wire, leg, longest_s)
        if share >= 1.0:
            return leg
        burst_s *= share
    raise refused or Refused("no burst is short enough for this device: see motion.jog_burst_s")


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
        full |= dict.fromkeys(("pitch", "roll", YAW_AXIS), math.degrees(ANGULAR_JOG_RAD_S))
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
    yaw = math.radians(jog.amount(YAW_AXIS) * factor)
    goal = Pose(
        pose.x_mm + x,
        pose.y_mm + y,
        pose.z_mm + z,
        pose.pitch_rad + math.radians(pitch),
        pose.roll_rad + math.radians(roll),
        None if pose.yaw_rad is None else pose.yaw_rad + yaw,
    )
    return Coordinates(arm.ik_near(goal, start.joints), opening_mm)


def _runs_on_s(core: Core) -> float:
    """Return how long the arm may run on while it stops, where it does not end by itself.

    A device without an abort ends each burst where it was audited to end.
    """
    if core.controller.abilities.abort is Abort.NONE:
        return 0.0
    return core.controller.stopping(core.config.motion.jog_burst_s).asked_motion_s


def _allowed(
    core: Core, start: Coordinates, goal: Coordinates, further: float = 0.0
) -> Coordinates:
    """Return the goal, drawn back to the joint limits and the gripper's range; guards refuse.

    They refuse as well where they would be passed `further` on, as a share of this way.
    """
    if not core.position_known:
        return goal
    clipped = Coordinates(_within_limits(core, start, goal), _within_range(core, start, goal))
    audit(core.config, [start.joints, clipped.joints], further)
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
