"""Forward and numerical inverse kinematics of any model on the command line.

A model is a built-in arm, a named system, or a model file. People type and read degrees and mm.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from armdrive.cli.presenter import Result
from armdrive.config.link_model import Model, is_model_file, read_model
from armdrive.errors import BadRequest, Refused
from kinematics.chains.chain import Chain
from kinematics.chains.goals import Goal, HandTask, Part, goal_of
from kinematics.chains.inverse import Solution, solve_goal, solve_pose_ik
from kinematics.chains.links import JointKind
from kinematics.errors import suggestion
from kinematics.frames.transforms import position_of
from kinematics.presets import PRESETS
from kinematics.spaces import Pose
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.worked_example import (
    FRAME_COORDINATES,
    coordinates_text,
    frame_coordinates,
    frame_text,
    joints_text,
    violation_text,
)


def find_model(word: str) -> Model:
    """Return a named system or a model file as a chain of links.

    Raises `BadRequest` for an unknown name, with the nearest one, and `ArmFileError` for a file
    that cannot be used.
    """
    if is_model_file(word):
        return read_model(word)
    if word in SYSTEMS:
        found = SYSTEMS[word]
        return Model(found.name, found.title, found.source, found.chain())
    known = list(dict.fromkeys((*PRESETS, *SYSTEMS)))
    hint = suggestion(word, known)
    raise BadRequest(
        f"no model is named {word!r}{hint} (there are {', '.join(known)}, and .toml files)"
    )


# People type and read degrees and mm; kinematics takes rad and mm.


def given_joints(chain: Chain, typed: Sequence[float]) -> tuple[float, ...]:
    """Return joint values in rad and mm. Raises `BadRequest` for too few or too many."""
    if len(typed) != len(chain):
        raise BadRequest(
            f"{len(chain)} joint values are required ({', '.join(chain.joint_names)}), "
            f"not {len(typed)}"
        )
    return tuple(
        math.radians(value) if kind is JointKind.REVOLUTE else value
        for value, kind in zip(typed, chain.kinds, strict=True)
    )


def given_goal(
    coordinates: Sequence[str], typed: Sequence[float], *, least: int | None = None
) -> tuple[float, ...]:
    """Return the coordinates of a goal in rad and mm.

    All are needed, or only the first `least`. Raises `BadRequest` for any other number.
    """
    if len(typed) not in (len(coordinates), least):
        names = [typed_name(name) for name in coordinates]
        fewer = f", or {', '.join(names[:least])} alone" if least else ""
        raise BadRequest(f"a goal is {', '.join(names)}{fewer}, not {len(typed)} numbers")
    return tuple(
        math.radians(value) if name.endswith("_rad") else value
        for name, value in zip(coordinates, typed, strict=False)
    )


def typed_coordinates(coordinates: Sequence[str], values: Sequence[float]) -> str:
    """Return the coordinates of a goal in words, as a person would type them."""
    pairs = map(shown, coordinates, values)
    return ", ".join(f"{name} {value:.6g}" for name, value in pairs)


def typed_name(name: str) -> str:
    """Return a coordinate's name with the unit that a person types: pitch_deg for pitch_rad."""
    return f"{name.removesuffix('_rad')}_deg" if name.endswith("_rad") else name


def shown(name: str, value: float) -> tuple[str, float]:
    """Return a coordinate as a person reads it, in mm and degrees."""
    return typed_name(name), math.degrees(value) if name.endswith("_rad") else value


def joint_name(name: str, kind: JointKind) -> str:
    """Return a joint's name with its unit."""
    return f"{name}_{'deg' if kind is JointKind.REVOLUTE else 'mm'}"


def shown_joints(chain: Chain, values: Sequence[float]) -> dict[str, float]:
    """Return joint values in degrees and mm, by names that say so."""
    return {
        joint_name(name, kind): math.degrees(value) if kind is JointKind.REVOLUTE else value
        for name, kind, value in zip(chain.joint_names, chain.kinds, values, strict=True)
    }


# Forward and inverse.


def fk(options: argparse.Namespace) -> Result:
    """Return the pose of the tip for joint values, and the limits that they violate."""
    model = find_model(options.model)
    values = given_joints(model.chain, options.joints)
    frame = model.chain.fk(values)
    x, y, z, *angles = frame_coordinates(frame)
    broken = [violation_text(each) for each in model.chain.violations(values)]
    view = {
        "model": model.name,
        "joints": shown_joints(model.chain, values),
        "frame": [list(row) for row in frame],
        "position_mm": [x, y, z],
        "rpy_deg": [math.degrees(angle) for angle in angles],
        "violations": broken,
    }
    lines = [
        f"{model.title}: {joints_text(model.chain, values)}",
        f"tip {coordinates_text(FRAME_COORDINATES, (x, y, z, *angles))}",
        *frame_text(frame),
        *(f"but: {sentence}" for sentence in broken),
    ]
    return Result(view, lines)


def ik(options: argparse.Namespace) -> Iterator[Result]:
    """Yield the posture that meets the goal; a pitch or roll that is not given is free.

    Without a yaw, the hand stays in the plane of the base axis and the tip.

    Raises `Refused` if no posture meets the goal, after yielding the nearest one.
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
    found = joints_text(model.chain, solution.joints)
    lines = (
        f"{model.title}, solved numerically",
        f"{'joints' if solution.ok else 'nearest'}: {found}",
        f"tip {coordinates_text(FRAME_COORDINATES, frame_coordinates(solution.frame))}",
        solution.sentence,
    )
    yield Result({"model": model.name, **solution_view(model.chain, solution)}, lines)
    if not solution.ok:
        raise Refused(f"the goal is not met: {solution.sentence}")


def _headed(chain: Chain, pose: Pose, yaw_deg: float, pitch_free: bool, roll_free: bool) -> Goal:
    """Return the goal of a hand with a yaw."""
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
