"""Forward and inverse kinematics of a built-in arm on the command line.

Those of any other model are in models.py, with the textbook that a built-in arm does without.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from armdrive.cli.options import load
from armdrive.cli.presenter import Result
from armdrive.errors import BadRequest
from armdrive.status import joints_view, pose_view, violation_text
from kinematics.five_axis.arm import Branch
from kinematics.presets import PRESETS, preset
from kinematics.spaces import JOINT_NAMES, Joints, Pose


def fk(options: argparse.Namespace) -> Result:
    """Return the pose, and the limits and guards that the posture would pass."""
    if options.model not in PRESETS:
        found: Result = load("learn.models:fk")(options)
        return found
    if len(options.joints) != len(JOINT_NAMES):
        raise BadRequest(
            f"{len(JOINT_NAMES)} joint angles are required ({', '.join(JOINT_NAMES)}), "
            f"not {len(options.joints)}"
        )
    model, joints = preset(options.model), Joints.of(*options.joints)
    pose = model.arm.fk(joints)
    broken = [violation_text(each) for each in model.arm.violations(joints)]
    broken += [each.sentence for each in model.guards.violations(model.arm, joints)]
    view = {
        "model": model.key,
        "joints": joints_view(joints),
        "pose": pose_view(pose),
        "violations": broken,
    }
    but = (f"but: {sentence}" for sentence in broken)
    return Result(view, (f"{model.title}: {joints}", f"tip {pose}", *but))


def ik(options: argparse.Namespace) -> Iterator[Result]:
    """Give every branch, then the one that the arm would take, or why there is none."""
    if options.model not in PRESETS:
        yield from load("learn.models:ik")(options)
        return
    if options.yaw is not None:
        raise BadRequest("--yaw is for a model of six joints: the hand of this one has none")
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
    view = {
        "model": model.key,
        "pose": pose_view(pose),
        "branches": [_branch_view(branch) for branch in branches],
    }
    yield Result(view, (f"{model.title}: {pose}", *map(_line, branches)))
    joints = model.arm.ik(pose)  # refuses with the reason and the nearest pose
    broken = model.guards.violation(model.arm, joints)
    but = () if broken is None else (f"but: {broken.sentence}",)
    yield Result(None, (f"taken: {joints}", *but))


def _line(branch: Branch) -> str:
    name = f"base {branch.base.value}, elbow {branch.elbow.value}"
    against = "; ".join(violation_text(each) for each in branch.violations)
    return f"  {name:<24}{branch.joints}" + (f"   ({against})" if against else "")


def _branch_view(branch: Branch) -> dict[str, Any]:
    return {
        "base": branch.base.value,
        "elbow": branch.elbow.value,
        "joints": joints_view(branch.joints),
        "within_limits": branch.within_limits,
        "violations": [violation_text(each) for each in branch.violations],
    }
