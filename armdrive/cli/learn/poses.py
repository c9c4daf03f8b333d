"""Forward and inverse kinematics of a built-in arm on the command line.

models.py does the same for any other model, and loads the textbook for it.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from typing import Any

from armdrive.cli.learn.joint_values import (
    BranchRow,
    branch_table,
    frame_view,
    require_values,
)
from armdrive.cli.presenter import Result
from armdrive.errors import BadRequest
from armdrive.status import joints_view, pose_view
from kinematics.frames.transforms import homogeneous
from kinematics.geometry import Branch
from kinematics.presets import PRESETS, preset
from kinematics.spaces import JOINT_NAMES, Joints, Pose
from kinematics.text import deg_text


def _of_models() -> tuple[
    Callable[[argparse.Namespace], Result], Callable[[argparse.Namespace], Iterator[Result]]
]:
    from armdrive.cli.learn import models  # the textbook, which a built-in arm does without

    return models.fk, models.ik


def fk(options: argparse.Namespace) -> Result:
    """Return the pose, and the limits and guards that the posture violates."""
    if options.model not in PRESETS:
        fk_of_model, _ = _of_models()
        return fk_of_model(options)
    require_values(JOINT_NAMES, options.joints)
    model, joints = preset(options.model), Joints.of(*options.joints)
    pose = model.arm.fk(joints)
    broken = [str(each) for each in model.arm.violations(joints)]
    broken += [each.sentence for each in model.guards.violations(model.arm, joints)]
    view = {
        "model": model.key,
        "joints": joints_view(joints),
        "pose": pose_view(pose),
        **frame_view(homogeneous(model.arm.hand_axes(joints), pose.position_mm)),
        "violations": broken,
    }
    but = (f"but: {sentence}" for sentence in broken)
    return Result(view, (f"{model.title}: {joints}", f"tip {pose}", *but))


def ik(options: argparse.Namespace) -> Iterator[Result]:
    """Return every solution and the one that the arm would use; if there is none, refuse.

    Yields the solutions before it raises `Unreachable`, which says why and names the nearest pose.
    """
    if options.model not in PRESETS:
        _, ik_of_model = _of_models()
        yield from ik_of_model(options)
        return
    if options.yaw is not None:
        raise BadRequest("--yaw is for a model with six joints: this hand has no yaw of its own")
    if options.pitch is None:
        raise BadRequest("--pitch is needed: the elevation of the hand, -90 points at the table")
    model = preset(options.model)
    pose = Pose.of(
        x_mm=options.x,
        y_mm=options.y,
        z_mm=options.z,
        pitch_deg=options.pitch,
        roll_deg=options.roll or 0.0,
    )
    branches = model.arm.branches(pose)
    joints = model.arm.solve(pose)
    broken = [] if joints is None else model.guards.violations(model.arm, joints)
    view = {
        "model": model.key,
        "pose": pose_view(pose),
        "ok": joints is not None,
        "joints": joints_view(joints),
        "violations": [each.sentence for each in broken],
        "branches": [_branch_view(branch) for branch in branches],
    }
    lines = [f"{model.title}: {pose}", *branch_table(JOINT_NAMES, tuple(map(_row, branches)))]
    if joints is not None:
        lines.append(f"the arm would use: {joints}")
        lines += [f"but: {each.sentence}" for each in broken]
    yield Result(view, lines)
    if joints is None:
        model.arm.ik(pose)  # refuses with the reason and the nearest pose


def _row(branch: Branch) -> BranchRow:
    return BranchRow(
        branch.name,
        tuple(map(deg_text, branch.joints.deg.values())),
        tuple(map(str, branch.violations)),
    )


def _branch_view(branch: Branch) -> dict[str, Any]:
    return {
        "name": branch.name,
        "joints": joints_view(branch.joints),
        "within_limits": branch.within_limits,
        "violations": [str(each) for each in branch.violations],
    }
