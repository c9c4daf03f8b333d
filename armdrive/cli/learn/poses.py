"""Forward and inverse kinematics on the command line: of a built-in arm here, else of a chain."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence

from armdrive.cli.options import Command
from armdrive.cli.presenter import emit, say
from armdrive.errors import BadRequest
from armdrive.status import joints_view, pose_view, violation_text
from kinematics.five_axis.arm import Branch
from kinematics.presets import PRESETS, ArmPreset, preset
from kinematics.spaces import JOINT_NAMES, Joints, Pose


def _of_chains() -> Mapping[str, Command]:
    from armdrive.cli.learn import chains  # the textbook, which a built-in arm does without

    return {"fk": chains.fk, "ik": chains.ik}


def fk(options: argparse.Namespace) -> int:
    """Print the pose, and the limits and guards that the posture would pass."""
    if options.model not in PRESETS:
        return _of_chains()["fk"](options)
    _show_fk(preset(options.model), options.joints, as_json=options.json)
    return 0


def _show_fk(model: ArmPreset, typed: Sequence[float], *, as_json: bool) -> None:
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


def ik(options: argparse.Namespace) -> int:
    """Print every branch, then the one that the arm would take, or why there is none."""
    if options.model not in PRESETS:
        return _of_chains()["ik"](options)
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
    if options.json:
        emit(
            {
                "model": model.key,
                "pose": pose_view(pose),
                "branches": [_branch_view(branch) for branch in branches],
            }
        )
    else:
        say(f"{model.title}: {pose}")
        for branch in branches:
            say(_line(branch))
    joints = model.arm.ik(pose)  # refuses with the reason and the nearest pose
    if not options.json:
        say(f"taken: {joints}")
        _say_guards(model, pose)
    return 0


def _say_guards(model: ArmPreset, pose: Pose) -> None:
    broken = model.guards.violation(model.arm, model.arm.ik(pose))
    if broken is not None:
        say(f"but: {broken.sentence}")


def _line(branch: Branch) -> str:
    name = f"base {branch.base.value}, elbow {branch.elbow.value}"
    against = "; ".join(violation_text(each) for each in branch.violations)
    return f"  {name:<24}{branch.joints}" + (f"   ({against})" if against else "")


def _branch_view(branch: Branch) -> dict[str, object]:
    return {
        "base": branch.base.value,
        "elbow": branch.elbow.value,
        "joints": joints_view(branch.joints),
        "within_limits": branch.within_limits,
        "violations": [violation_text(each) for each in branch.violations],
    }
