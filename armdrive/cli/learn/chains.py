"""Kinematics of any chain of links on the command line, both ways; the inverse by numbers."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from typing import Any

from armdrive.cli.learn.models import find_model, given_joints, shown_joints
from armdrive.cli.presenter import emit, say
from armdrive.config.link_model import Model
from armdrive.errors import Refused
from kinematics.chains.chain import Chain
from kinematics.chains.goals import Goal, HandTask, Part, goal_of
from kinematics.chains.inverse import Solution, solve_goal, solve_pose_ik
from kinematics.frames.transforms import position_of
from kinematics.spaces import Pose
from kinematics.textbook.worked_example import (
    FRAME_COORDINATES,
    coordinates_text,
    frame_coordinates,
    frame_text,
    joints_text,
    violation_text,
)


def fk(options: argparse.Namespace) -> int:
    """Print where joint values put the tip of a chain, and the limits that they would pass."""
    model = find_model(options.model)
    values = given_joints(model.chain, options.joints)
    frame = model.chain.fk(values)
    x, y, z, *angles = frame_coordinates(frame)
    broken = [violation_text(each) for each in model.chain.violations(values)]
    if options.json:
        emit(
            {
                "model": model.name,
                "joints": shown_joints(model.chain, values),
                "frame": [list(row) for row in frame],
                "position_mm": [x, y, z],
                "rpy_deg": [math.degrees(angle) for angle in angles],
                "violations": broken,
            }
        )
        return 0
    say(f"{model.title}: {joints_text(model.chain, values)}")
    say(f"tip {coordinates_text(FRAME_COORDINATES, (x, y, z, *angles))}")
    for line in frame_text(frame):
        say(line)
    for sentence in broken:
        say(f"but: {sentence}")
    return 0


def ik(options: argparse.Namespace) -> int:
    """Print the posture that meets the goal; pitch and roll that are not given are free.

    Without a yaw the hand is asked into the plane of base axis and tip.

    Raises `Refused` where it is not met, after printing the posture that comes nearest.
    """
    model = find_model(options.model)
    pose = Pose.of(
        x_mm=options.x,
        y_mm=options.y,
        z_mm=options.z,
        pitch_deg=options.pitch or 0.0,
        roll_deg=options.roll or 0.0,
    )
    pitch_free, roll_free = options.pitch is None, options.roll is None
    if options.yaw is None:
        solution = solve_pose_ik(model.chain, pose, pitch_free=pitch_free, roll_free=roll_free)
    else:
        goal = _headed(model.chain, pose, options.yaw, pitch_free, roll_free)
        solution = solve_goal(model.chain, goal)
    if options.json:
        emit({"model": model.name, **solution_view(model.chain, solution)})
    else:
        _say(model, solution)
    if not solution.ok:
        raise Refused(f"the goal is not met: {solution.sentence}")
    return 0


def _headed(chain: Chain, pose: Pose, yaw_deg: float, pitch_free: bool, roll_free: bool) -> Goal:
    """Return the goal of a hand that points in a direction of its own."""
    headed = replace(pose, yaw_rad=math.radians(yaw_deg))
    goal = goal_of(headed, HandTask.WHOLE, position_of(chain.base))
    free = {Part.PITCH} if pitch_free else set()
    free |= {Part.ROLL} if roll_free else set()
    return replace(goal, parts=goal.parts - free)


def solution_view(chain: Chain, solution: Solution) -> dict[str, Any]:
    """Return a numerical solution as plain data, in mm and degrees."""
    return {
        "joints": shown_joints(chain, solution.joints),
        "frame": [list(row) for row in solution.frame],
        "ok": solution.ok,
        "met": sorted(part.value for part in solution.met),
        "missed": sorted(part.value for part in solution.missed),
        "residual_mm": solution.residual_mm,
        "residual_deg": math.degrees(solution.residual_rad),
        "at_limit": list(solution.at_limit),
        "sentence": solution.sentence,
    }


def _say(model: Model, solution: Solution) -> None:
    say(f"{model.title}, solved by numbers")
    say(f"{'joints' if solution.ok else 'nearest'}: {joints_text(model.chain, solution.joints)}")
    say(f"tip {coordinates_text(FRAME_COORDINATES, frame_coordinates(solution.frame))}")
    say(solution.sentence)
