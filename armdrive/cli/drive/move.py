"""Planned motion: `armdrive move` and `points go`; and `points save`, which connects as they do."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_points, chosen_target
from armdrive.cli.chosen_arm import opened_arm
from armdrive.cli.presenter import Result
from armdrive.cli.terminal_operator import confirm_simulated, ready_arm, settled_arm
from armdrive.errors import BadRequest, WrongState
from armdrive.motion.frames import require_frame
from armdrive.motion.preview import preview_lines, preview_view
from armdrive.moves import (
    BASE_FRAME,
    TOOL_FRAME,
    ArcMove,
    GripperMove,
    JointMove,
    LineMove,
    Motion,
    MoveSequence,
    ParkMove,
    PoseMove,
)
from armdrive.status import State, pose_numbers, status_view
from armdrive.storage.points import check_name, point_view
from kinematics.errors import suggestion
from kinematics.spaces import JOINT_NAMES, NO_YAW, POSE_FIELDS, Pose


def move(options: argparse.Namespace) -> Iterator[Result]:
    """Move, and yield where the arm is then; what is left out of the goal does not change."""
    _check(options)
    return _moved(options, lambda arm: _asked(arm, options))


def _moved(
    options: argparse.Namespace, asked: Callable[[Arm], Motion | MoveSequence]
) -> Iterator[Result]:
    """Run a move, or with --preview only plan it: a refusal is raised after what was planned."""
    if options.preview:
        yield from _previewed(options, asked)
        return
    with ready_arm(options) as arm:
        done = arm.run(asked(arm))
        result = Result(status_view(arm.status), str(done))
    yield result


def _previewed(
    options: argparse.Namespace, asked: Callable[[Arm], Motion | MoveSequence]
) -> Iterator[Result]:
    """Plan a move. The motors and the position's trust are unchanged, and no question is asked."""
    with opened_arm(options) as arm:
        confirm_simulated(arm)
        preview = arm.preview(asked(arm))
        if arm.status.state is State.DISABLED and isinstance(preview.hindrance, WrongState):
            preview = replace(preview, hindrance=None)  # the move switches the motors on itself
    yield Result(preview_view(preview), preview_lines(preview))
    if preview.refusal is not None:
        raise preview.refusal


def _names_pose(options: argparse.Namespace) -> bool:
    return any(getattr(options, axis) is not None for axis in POSE_FIELDS)


def _check(options: argparse.Namespace) -> None:
    pose = _names_pose(options)
    joints = bool(_joints(options))
    if pose + joints + options.park + (options.gripper is not None) == 0:
        raise BadRequest(
            "name a goal: --x, --y, --z, --pitch, --roll, a joint, --gripper or "
            "--park; `armdrive move --help` shows examples"
        )
    if pose + joints + options.park > 1:
        raise BadRequest("give either a pose, joint angles or --park, not two of them")
    if options.frame not in (None, BASE_FRAME) and not pose:
        raise BadRequest("--frame needs a pose, for example --frame tool --z -30 --line")
    if options.via is not None and (options.line or not pose):
        raise BadRequest("--via needs a pose to lead to and no --line, for example --via 250,0,120")
    if options.line and not pose:
        raise BadRequest("--line needs a pose to lead to, for example --y 80 --line")
    _check_arm_has(options)


def _check_arm_has(options: argparse.Namespace) -> None:
    """Refuse what the arm does not have, before anything is opened."""
    config = chosen_target(options).config
    if options.yaw is not None and not config.model.arm.has_yaw:
        raise BadRequest(NO_YAW)
    if options.frame is not None:
        require_frame(config, options.frame)
    joints = config.model.arm.joint_names
    for name in (key.removesuffix("_deg") for key in _joints(options)):
        if name not in joints:
            near = suggestion(name, joints)
            raise BadRequest(f"this arm has no joint {name!r}, but {', '.join(joints)}{near}")


def _asked(arm: Arm, options: argparse.Namespace) -> Motion | MoveSequence:
    """Return the options as one move: the arm first, then the gripper."""
    moves = [*_arm_move(arm, options)]
    if options.gripper is not None:
        moves.append(GripperMove(options.gripper, options.speed))
    return moves[0] if len(moves) == 1 else MoveSequence(tuple(moves))


def _arm_move(arm: Arm, options: argparse.Namespace) -> Iterator[Motion]:
    named = _joints(options)
    if options.park:
        yield ParkMove(options.speed)
    elif named:
        yield JointMove(named, options.speed)
    elif _names_pose(options):
        frame = options.frame or BASE_FRAME
        goal = _goal(_here(arm, frame), options)
        if options.via is not None:
            yield ArcMove(_placed(goal, options.via), goal, options.speed, frame)
        elif options.line:
            yield LineMove(goal, options.speed, frame)
        else:
            yield PoseMove(goal, options.speed, frame)


def _joints(options: argparse.Namespace) -> dict[str, Any]:
    """Return the joint angles of the options, under the keys of `JointMove`."""
    known = ((name, getattr(options, name)) for name in JOINT_NAMES)
    given = [*((name, angle) for name, angle in known if angle is not None), *options.joint]
    return {f"{name}_deg": angle for name, angle in given}


def _placed(pose: Pose, point: tuple[float, ...]) -> Pose:
    x, y, z = point
    return replace(pose, x_mm=x, y_mm=y, z_mm=z)


def _here(arm: Arm, frame: str) -> Pose:
    """Return the coordinates to keep if they are not given: in the tool's frame, no change."""
    if frame != TOOL_FRAME:
        return arm.pose_in(frame)
    return Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0 if arm.model.arm.has_yaw else None)


def _goal(here: Pose, options: argparse.Namespace) -> Pose:
    typed = {key: getattr(options, axis) for axis, key in POSE_FIELDS.items()}
    given = {key: float(value) for key, value in typed.items() if value is not None}
    return Pose.of(**(pose_numbers(here) | given))


# Saved points, as far as an arm is needed.


def save_point(options: argparse.Namespace) -> Result:
    """Save the arm's present place."""
    check_name(options.name)  # before anything is opened or asked
    with settled_arm(options) as arm:
        point = arm.points.teach(options.name, note=options.note, again=options.again)
    return Result({"name": options.name, **point_view(point)}, f"{options.name}: {point.joints}")


def go_to_point(options: argparse.Namespace) -> Iterator[Result]:
    """Move to a point, or preview that."""
    _, book = chosen_points(options)
    book[options.name]  # refused before anything is opened
    kind = LineMove if options.line else PoseMove
    return _moved(options, lambda _: kind(options.name, options.speed))
