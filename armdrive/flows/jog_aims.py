"""Where a jog leads: which axes it may move, the point it displaces to, and where bounds hold it.

Joint limits and the gripper's range clip a jog; guards refuse it, with the way that the arm runs on
while it stops added. Moving away from a bound that is already passed is always allowed.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from armdrive.abilities import Abort
from armdrive.core import Coordinates
from armdrive.errors import BadRequest, NotReferenced, WrongState
from armdrive.flows.gripping import require_finger_motor
from armdrive.intents import CARTESIAN_AXES, GRIPPER_AXIS, YAW_AXIS, Jog, Space
from armdrive.planning import audit
from kinematics import Joints, Pose

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.planning import Speeds

ANGULAR_JOG_RAD_S = math.radians(45.0)
"""Pitch and roll of a Cartesian jog at full speed, before the joints' limits slow it."""


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


def capped(core: Core, speed: float) -> float:
    """Return the speed, slowed where the position is not known."""
    return speed if core.position_known else min(speed, core.config.motion.unreferenced_speed)


def rates_of(core: Core, jog: Jog, speeds: Speeds) -> Jog:
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


def runs_on_s(core: Core) -> float:
    """Return how long the arm may run on while it stops, where it does not end by itself.

    A device without an abort ends each burst where it was audited to end.
    """
    if core.controller.abilities.abort is Abort.NONE:
        return 0.0
    return core.controller.stopping(core.config.motion.jog_burst_s).asked_motion_s


def allowed(core: Core, start: Coordinates, goal: Coordinates, further: float = 0.0) -> Coordinates:
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
