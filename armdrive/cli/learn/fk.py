"""Forward kinematics on the command line."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

from armdrive.cli.learn.models import find_model, given_joints, shown_joints
from armdrive.cli.presenter import emit, say
from armdrive.config.link_model import Model
from armdrive.errors import BadRequest
from armdrive.status import joints_view, pose_view, violation_text
from kinematics.presets import PRESETS, ArmPreset, preset
from kinematics.spaces import JOINT_NAMES, Joints
from kinematics.textbook import worked_example as worked_text
from kinematics.textbook.worked_example import FRAME_COORDINATES, frame_coordinates


def run(options: argparse.Namespace) -> int:
    """Print the pose, and the limits and guards that the posture would pass."""
    if options.model in PRESETS:
        _of_preset(preset(options.model), options.joints, as_json=options.json)
    else:
        _of_chain(find_model(options.model), options.joints, as_json=options.json)
    return 0


def _of_preset(model: ArmPreset, typed: Sequence[float], *, as_json: bool) -> None:
    if len(typed) != len(JOINT_NAMES):
        raise BadRequest(
            f"{len(JOINT_NAMES)} joint angles are required ({', '.join(JOINT_NAMES)}), "
            f"not {len(typed)}"
        )
    joints = Joints.of(*typed)
    pose = model.arm.fk(joints)
    broken = [violation_text(each) for each in model.arm.violations(joints)]
    broken += [each.sentence for each in model.guards.violations(model.arm, joints)]
    if as_json:
        emit(
            {
                "model": model.key,
                "joints": joints_view(joints),
                "pose": pose_view(pose),
                "violations": broken,
            }
        )
        return
    say(f"{model.title}: {joints}")
    say(f"tip {pose}")
    for sentence in broken:
        say(f"but: {sentence}")


def _of_chain(model: Model, typed: Sequence[float], *, as_json: bool) -> None:
    values = given_joints(model.chain, typed)
    frame = model.chain.fk(values)
    x, y, z, *angles = frame_coordinates(frame)
    broken = [worked_text.violation_text(each) for each in model.chain.violations(values)]
    if as_json:
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
        return
    say(f"{model.title}: {worked_text.joints_text(model.chain, values)}")
    say(f"tip {worked_text.coordinates_text(FRAME_COORDINATES, (x, y, z, *angles))}")
    for line in worked_text.frame_text(frame):
        say(line)
    for sentence in broken:
        say(f"but: {sentence}")
