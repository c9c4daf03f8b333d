"""Planned motion on the command line: joints that are not named stay, and so do coordinates.

Examples:
  armdrive move --x 250 --z 120 --pitch -90           to a pose, by a joint motion
  armdrive move --y 80 --line                         along a straight line
  armdrive move --y 80 --via 270,0,120                along an arc through that point
  armdrive move --frame tool --z -30 --line           30 mm back, as the hand points
  armdrive move --shoulder 40 --elbow -60 --speed 0.5
  armdrive move --gripper 40
  armdrive move --park
  armdrive move --y 80 --line --preview               moves nothing: what it would be

"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.arm_options import add_allow_restored, add_arm_options
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.preview_report import show_preview
from armdrive.cli.options import fraction, number
from armdrive.cli.presenter import emit, say, say_which
from armdrive.cli.terminal_person import settle_trust
from armdrive.errors import BadRequest
from armdrive.motion.preview import Preview
from armdrive.motion.resolve import BASE, TOOL
from armdrive.status import status_view
from kinematics.spaces import JOINT_NAMES, Pose

COORDINATES = (
    ("x", "mm"), ("y", "mm"), ("z", "mm"), ("pitch", "deg"), ("roll", "deg"), ("yaw", "deg"),
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    goal = parser.add_argument_group("to a pose (what is not named stays)")
    for axis, unit in COORDINATES:
        goal.add_argument(f"--{axis}", type=number, metavar=unit.upper())
    goal.add_argument("--line", action="store_true", help="along a straight line")
    goal.add_argument(
        "--via", type=_point, metavar="X,Y,Z", help="along the arc of a circle through this point"
    )
    goal.add_argument(
        "--frame",
        default=BASE,
        metavar="NAME",
        help="the pose is one of a frame of the arm file; of tool: a change from where it is",
    )
    turn = parser.add_argument_group("or to joint angles (what is not named stays)")
    for name in JOINT_NAMES:
        turn.add_argument(f"--{name.replace('_', '-')}", type=number, metavar="DEG")
    turn.add_argument(
        "--joint",
        action="append",
        type=_named_angle,
        default=[],
        metavar="NAME=DEG",
        help="a joint of an arm that is given by a model file; may be repeated",
    )
    parser.add_argument("--gripper", type=number, metavar="MM", help="open or close to a width")
    parser.add_argument("--park", action="store_true", help="to the park posture")
    parser.add_argument("--speed", type=fraction, default=1.0, help="fraction of the limits")
    parser.add_argument(
        "--preview",
        action="store_true",
        help="say what the motion would be, every solution and margin; moves nothing",
    )
    add_allow_restored(parser)
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Move, and say where the arm is then."""
    _check(options)
    with connect_chosen(options, allow_restored=options.allow_restored) as arm:
        if not options.json:
            say_which(arm.status)
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


def _named_angle(word: str) -> tuple[str, float]:
    name, equals, angle = word.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"write it like shoulder=40, not {word!r}")
    return name, number(angle)


def _point(word: str) -> tuple[float, ...]:
    found = tuple(map(number, word.split(",")))
    if len(found) != len("xyz"):
        raise argparse.ArgumentTypeError(f"write it like 250,0,120, not {word!r}")
    return found


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
