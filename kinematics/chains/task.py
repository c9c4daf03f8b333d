"""The task of a chain's hand: its frame as a pose, a pose as a goal, and why a pose is refused.

The hand points along z of the tool's frame; x of that frame is its roll reference. Three kinds of
arms have three tasks. An arm of six joints takes any frame: its pitch is the elevation of the hand,
its yaw the direction of the vertical plane that the hand lies in, and its roll is counted from
upwards in that plane. Five joints leave the yaw to the arm. Where such an arm keeps its hand in the
plane of base axis and tip, as the Mini-mover's build does, pitch counts outwards in that plane and
may pass the vertical, as `FiveAxisArm` has it. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from enum import Enum

from kinematics.chains.chain import Chain
from kinematics.chains.goals import VERTICAL, Goal, Part, hand_frame, pose_goal, upwards
from kinematics.chains.inverse import Reason, Solution
from kinematics.errors import Constraint, KinematicsError, Unreachable, limit_sentence
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import Transform, position_of, rotation_of
from kinematics.frames.vectors import (
    X_AXIS,
    Z_AXIS,
    Vector,
    cross,
    dot,
    norm,
    subtract,
    unit,
)
from kinematics.paths.curves import largest_turn, leap_sentence
from kinematics.spaces import Joints, Pose

AXIS_MM = 1e-6
"""A tip nearer to the base axis than this is on it, and no direction is outwards."""

PLANE_SINE = 1e-9
"""A hand that leaves the plane of base axis and tip by less than this lies in it."""

_LOOKS = 8


class HandTask(Enum):
    """What an arm can ask of its hand."""

    IN_PLANE = "position, pitch in the arm's plane, roll"
    ELEVATION = "position, elevation of the hand, roll; the heading is the arm's"
    WHOLE = "position, pitch, roll and yaw"


def task_of(chain: Chain) -> HandTask:
    """Return the task of a chain of five or six joints; `KinematicsError` for any other number."""
    if len(chain) == 6:
        return HandTask.WHOLE
    if len(chain) != 5:
        raise KinematicsError(
            f"an arm that is to be driven has five or six joints, not {len(chain)}"
        )
    draw = random.Random(1)  # noqa: S311 - any postures will do
    postures = (tuple(draw.uniform(-3.0, 3.0) for _ in chain.links) for _ in range(_LOOKS))
    centre = position_of(chain.base)
    planar = all(abs(_off_plane(chain.fk(values), centre)) < PLANE_SINE for values in postures)
    return HandTask.IN_PLANE if planar else HandTask.ELEVATION


def pose_of(frame: Transform, task: HandTask, centre: Vector) -> Pose:
    """Return the pose of the hand's frame; `centre` is a point of the base axis."""
    x, _, hand = columns(rotation_of(frame))
    if task is HandTask.IN_PLANE:
        outwards = _outwards(frame, centre)
        pitch = math.atan2(hand[2], dot(hand, outwards))
    else:
        level = (hand[0], hand[1], 0.0)
        outwards = unit(level) if norm(level) > VERTICAL else X_AXIS
        pitch = math.atan2(hand[2], norm(level))
    up = upwards(outwards, pitch)
    roll = math.atan2(dot(x, cross(hand, up)), dot(x, up))
    yaw = math.atan2(outwards[1], outwards[0]) if task is HandTask.WHOLE else None
    return Pose(*position_of(frame), pitch, roll, yaw)


def goal_of(pose: Pose, task: HandTask, centre: Vector) -> Goal:
    """Return what a pose asks of the hand. Raises `KinematicsError` for a missing or extra yaw."""
    if (pose.yaw_rad is not None) != (task is HandTask.WHOLE):
        raise KinematicsError(
            "this arm has six joints, so its poses need a yaw: give yaw_deg"
            if task is HandTask.WHOLE
            else "this arm has five joints: it cannot take a yaw, which follows from the position"
        )
    if task is HandTask.IN_PLANE:
        return pose_goal(pose, centre=centre)
    heading = pose.yaw_rad or 0.0
    outwards = (math.cos(heading), math.sin(heading), 0.0)
    frame = hand_frame(pose, outwards, pose.roll_rad)
    hand = columns(rotation_of(frame))[2]
    if task is HandTask.WHOLE:
        return Goal(frame, outwards)
    level = (hand[0], hand[1], 0.0)
    return Goal(
        frame,
        unit(level) if norm(level) > VERTICAL else outwards,
        frozenset({Part.POSITION, Part.PITCH, Part.ROLL}),
    )


def _outwards(frame: Transform, centre: Vector) -> Vector:
    """Return the level direction from the base axis to the tip, or on it that of the hand."""
    off = subtract(position_of(frame), centre)
    level = (off[0], off[1], 0.0)
    if norm(level) > AXIS_MM:
        return unit(level)
    hand = columns(rotation_of(frame))[2]
    level = (hand[0], hand[1], 0.0)
    return unit(level) if norm(level) > VERTICAL else X_AXIS


def _off_plane(frame: Transform, centre: Vector) -> float:
    """Return the sine by which the hand leaves the plane of base axis and tip."""
    hand = columns(rotation_of(frame))[2]
    return dot(hand, cross(Z_AXIS, _outwards(frame, centre)))


# Why an arm given by its link table cannot take a pose, and which pose it can take instead.
#
# What numbers did not find is not proved to be out of reach, and the sentence says so.

HELD_RAD = 1e-6
"""An angle of the hand nearer to the asked one than this is the asked one."""


def chain_refusal(chain: Chain, task: HandTask, pose: Pose, found: Solution) -> Unreachable:
    """Return the error that explains the best posture found for a pose."""
    nearest = nearest_of(chain, task, pose, found)
    if found.reason is Reason.BEYOND_REACH:
        centre, radius = chain.reach_sphere
        away = math.dist((pose.x_mm, pose.y_mm, pose.z_mm), centre)
        reason = (
            f"the tip would be {away - radius:.1f} mm beyond the {radius:.1f} mm that all links "
            "together span"
        )
        return _refused(Constraint.TOO_FAR, reason, away, radius, "mm", pose, nearest)
    if found.reason is Reason.JOINT_LIMIT and found.violations:
        worst = max(found.violations, key=lambda one: one.excess)
        reason = limit_sentence(worst.joint, worst.value, worst.bound)
        return _refused(
            Constraint.JOINT_LIMIT,
            reason,
            worst.value,
            worst.bound,
            "rad",
            pose,
            nearest,
            joint=worst.joint,
        )
    return _not_found(pose, nearest, found)


def step_refusal(
    chain: Chain, task: HandTask, pose: Pose, found: Solution, seed: Joints, here: Pose
) -> Unreachable:
    """Return the error for a small step that leads nowhere near the posture it starts from.

    `here` is the pose of that posture.
    """
    if found.ok:
        name, turn = largest_turn(seed, Joints(found.joints, chain.joint_names))
        reason = leap_sentence(name, turn, "the posture is singular here")
        return _refused(Constraint.NO_POSTURE, reason, turn, 0.0, "rad", pose, here)
    if found.at_limit:
        joint = found.at_limit[0]
        index = chain.joint_names.index(joint)
        value, nearest = found.joints[index], nearest_of(chain, task, pose, found)
        reason = f"the {joint.replace('_', ' ')} is at its limit of {math.degrees(value):.1f}°"
        return _refused(
            Constraint.JOINT_LIMIT, reason, value, value, "rad", pose, nearest, joint=joint
        )
    return _not_found(pose, nearest_of(chain, task, pose, found), found)


def nearest_of(chain: Chain, task: HandTask, pose: Pose, found: Solution) -> Pose:
    """Return the pose of the best posture found, in the goal's own angles where they are held.

    A tip on the other side of the base axis than the goal holds another pitch and roll, although
    its hand points where the goal's does.
    """
    reached = pose_of(found.frame, task, position_of(chain.base))
    pairs = (
        (pose.pitch_rad, reached.pitch_rad),
        (pose.roll_rad, reached.roll_rad),
        (pose.yaw_rad or 0.0, reached.yaw_rad or 0.0),
    )
    if all(abs(math.remainder(a - b, math.tau)) <= HELD_RAD for a, b in pairs):
        return replace(pose, x_mm=reached.x_mm, y_mm=reached.y_mm, z_mm=reached.z_mm)
    return reached


def _not_found(pose: Pose, nearest: Pose, found: Solution) -> Unreachable:
    away = math.dist((pose.x_mm, pose.y_mm, pose.z_mm), (nearest.x_mm, nearest.y_mm, nearest.z_mm))
    if found.residual_rad > HELD_RAD:
        gap = math.degrees(found.residual_rad)
        reason = f"no posture was found; the nearest one misses the hand's direction by {gap:.2f}°"
        value, unit = found.residual_rad, "rad"
    else:
        reason = f"no posture was found; the nearest one stays {away:.2f} mm away"
        value, unit = away, "mm"
    return _refused(Constraint.NO_POSTURE, reason, value, 0.0, unit, pose, nearest)


def _refused(
    constraint: Constraint,
    reason: str,
    value: float,
    bound: float,
    unit: str,
    goal: Pose,
    nearest: Pose,
    joint: str | None = None,
) -> Unreachable:
    return Unreachable(
        reason,
        constraint=constraint,
        joint=joint,
        value=value,
        bound=bound,
        unit=unit,
        goal=goal,
        nearest=nearest,
    )
