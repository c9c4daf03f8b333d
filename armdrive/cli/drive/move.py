"""Planned motion on the command line: joints that are not named stay, and so do coordinates."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.arguments import COORDINATES
from armdrive.cli.drive.preview_report import show_preview
from armdrive.cli.presenter import emit, say
from armdrive.cli.terminal_person import settle_trust
from armdrive.errors import BadRequest
from armdrive.motion.preview import Preview
from armdrive.motion.resolve import BASE, TOOL
from armdrive.status import status_view
from kinematics.spaces import JOINT_NAMES, Pose


def run(options: argparse.Namespace) -> int:
    """Move, and say where the arm is then."""
    _check(options)
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say(arm.status.which)
        settle_trust(arm)
        if options.preview:
            return show_preview(_preview(arm, options), as_json=options.json)
        for moved in _moves(arm, options):
            if not options.json:
                say(str(moved))
        if options.json:
            emit(status_view(arm.status))
    return 0


def _check(options: argparse.Namespace) -> None:
    pose = any(getattr(options, axis) is not None for axis, _ in COORDINATES)
    joints = bool(_joints(options))
    if pose + joints + options.park + (options.gripper is not None) == 0:
        raise BadRequest(
            "where to? Give --x, --y, --z, --pitch, --roll, a joint, --gripper or "
            "--park; `armdrive move --help` shows examples"
        )
    if pose + joints + options.park > 1:
        raise BadRequest("give a pose or joint angles or --park, not two of them")
    if options.frame != BASE and not pose:
        raise BadRequest("--frame needs a pose, for example --frame tool --z -30 --line")
    if options.via is not None and (options.line or not pose):
        raise BadRequest("--via needs a pose to lead to and no --line, for example --via 250,0,120")
    if options.preview and (options.via is not None or not (pose or joints)):
        raise BadRequest("--preview is of a pose or of joints, without --via")
    if options.line and not pose:
        raise BadRequest("--line needs a pose to lead to, for example --y 80 --line")


def _moves(arm: Arm, options: argparse.Namespace) -> list[object]:
    done: list[object] = []
    named = _joints(options)
    if options.park:
        done.append(arm.park(speed=options.speed))
    elif named:
        done.append(arm.move_j(named, speed=options.speed))
    elif any(getattr(options, axis) is not None for axis, _ in COORDINATES):
        goal = _goal(_here(arm, options.frame), options)
        how = {"speed": options.speed, "frame": options.frame}
        if options.via is not None:
            done.append(arm.move_c(_placed(goal, options.via), goal, **how))
        else:
            done.append((arm.move_l if options.line else arm.move_to)(goal, **how))
    if options.gripper is not None:
        done.append(arm.gripper.move(options.gripper, speed=options.speed))
    return done


def _preview(arm: Arm, options: argparse.Namespace) -> Preview:
    """Return what the motion would be; fingers that are to be moved besides are not in it."""
    named = _joints(options)
    if named:
        return arm.preview(named, speed=options.speed)
    goal = _goal(_here(arm, options.frame), options)
    return arm.preview(goal, line=options.line, frame=options.frame, speed=options.speed)


def _joints(options: argparse.Namespace) -> dict[str, Any]:
    """Return the joint angles asked for, by the words that `move_j` takes."""
    known = ((name, getattr(options, name)) for name in JOINT_NAMES)
    given = [*((name, angle) for name, angle in known if angle is not None), *options.joint]
    return {f"{name}_deg": angle for name, angle in given}


def _placed(pose: Pose, point: tuple[float, ...]) -> Pose:
    x, y, z = point
    return replace(pose, x_mm=x, y_mm=y, z_mm=z)


def _here(arm: Arm, frame: str) -> Pose:
    """Return what coordinates are that nobody names: in the tool's frame, no change."""
    if frame != TOOL:
        return arm.pose_in(frame)
    return Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0 if arm.model.arm.has_yaw else None)


def _goal(here: Pose, options: argparse.Namespace) -> Pose:
    def asked(axis: str, present: float) -> float:
        value = getattr(options, axis)
        return present if value is None else float(value)

    return Pose.of(
        x_mm=asked("x", here.x_mm),
        y_mm=asked("y", here.y_mm),
        z_mm=asked("z", here.z_mm),
        pitch_deg=asked("pitch", here.pitch_deg),
        roll_deg=asked("roll", here.roll_deg),
        yaw_deg=options.yaw if here.yaw_deg is None else asked("yaw", here.yaw_deg),
    )
