"""The JSON forms that every output and input shares: moves, poses, joint angles, status, errors.

`--json`, the recorder, the journals and the control socket all use these forms: mm and degrees,
with the unit in the key.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from armdrive.errors import BadArgument
from armdrive.moves import (
    BASE_FRAME,
    LENGTHS,
    Angles,
    ArcMove,
    GraspMove,
    GripperMove,
    Jog,
    JogMove,
    JointMove,
    LineMove,
    Move,
    MoveSequence,
    ParkMove,
    PathMove,
    PoseMove,
    Space,
    jog_axes,
)
from armdrive.status import STATUS_FIELDS, joints_numbers, pose_numbers
from armdrive.text.form import (
    NUMBER,
    TEXT,
    Fields,
    Form,
    Json,
    misfit,
    numbers,
    optional,
    record,
    several,
    tagged,
)
from kinematics.paths.routes import ArcPart, JointPart, LinePart, PosePart
from kinematics.spaces import Joints, Pose

# The JSON form of moves: an object with the fields of the move, and its kind under `move`.


def move_to_json(move: Move) -> dict[str, Json]:
    """Return a move as plain data. Raises `BadArgument` for what is no move, such as a hold."""
    written: dict[str, Json] = move_form().write(move)
    return written


def move_from_json(data: Json) -> Move:
    """Return the move of plain data. Raises `BadArgument` or `BadRequest` that says where."""
    move: Move = move_form().read(data, "move")
    return move


@functools.cache
def move_form() -> Form[Any]:
    """Return the JSON form of all moves, with its schema."""
    framed: Fields = {"speed": NUMBER, "frame": TEXT}
    opening: Fields = {"opening_mm": optional(NUMBER), "speed": NUMBER}
    single: dict[str, tuple[type, Fields | Form[Any]]] = {
        "joint": (JointMove, {"goal": _ANGLES, "speed": NUMBER}),
        "pose": (PoseMove, {"goal": _PLACE, **framed}),
        "line": (LineMove, {"goal": _AIM, **framed}),
        "arc": (ArcMove, {"via": POSE, "goal": POSE, **framed}),
        "path": (PathMove, {"parts": several(_part_form()), **framed}),
        "gripper": (GripperMove, opening),
        "grasp": (GraspMove, {"force_n": NUMBER}),
        "park": (ParkMove, {"speed": NUMBER, "goal": optional(POSE)}),
        "jog": (JogMove, _jog_form()),
    }
    sequence = {"moves": several(tagged("move", single))}
    return tagged("move", {**single, "sequence": (MoveSequence, sequence)})


def _part_form() -> Form[Any]:
    bend: Fields = {"via": POSE, "goal": POSE, "sweep_rad": optional(NUMBER), "blend_mm": NUMBER}
    return tagged(
        "part",
        {
            "joint": (JointPart, {"goal": JOINTS, "blend_mm": NUMBER}),
            "pose": (PosePart, {"goal": POSE, "blend_mm": NUMBER}),
            "line": (LinePart, {"goal": POSE, "blend_mm": NUMBER}),
            "arc": (ArcPart, bend),
        },
    )


# Poses and joint angles in JSON: mm and degrees, with the keys that every other output has.


def _read_pose(data: Json, where: str) -> Pose:
    given = _NUMBERS.read(data, where)
    if missing := [key for key in _POSE_KEYS[:4] if key not in given]:
        raise BadArgument(f"{where} has no {missing[0]!r}")
    if strange := [key for key in given if key not in _POSE_KEYS]:
        known = ", ".join(_POSE_KEYS)
        raise BadArgument(f"{where} has a key {strange[0]!r:.40}; known are {known}")
    return Pose.of(**given)


def _read_joints(data: Json, where: str) -> Joints:
    given = _ANGLES.read(data, where)
    names = tuple(word.removesuffix("_deg") for word in given)
    return Joints.of(*given.values(), names=names)


def _read_angles(data: Json, where: str) -> Mapping[str, float]:
    given = _NUMBERS.read(data, where)
    if wrong := [word for word in given if not word.endswith("_deg")]:
        raise BadArgument(f"{where} has a key {wrong[0]!r:.40}: a joint is named as shoulder_deg")
    if not given:
        raise misfit(where, "angles by the names of joints", data)
    return given


def _write_joints(joints: Joints | Angles) -> Json:
    return joints_numbers(joints) if isinstance(joints, Joints) else dict(joints)


def _write_goal(goal: Pose | Joints | str) -> Json:
    if isinstance(goal, str):
        return goal
    return pose_numbers(goal) if isinstance(goal, Pose) else _write_joints(goal)


def _read_place(data: Json, where: str) -> Pose | str:
    return data if isinstance(data, str) else _read_pose(data, where)


def _read_aim(data: Json, where: str) -> Pose | Joints | str:
    if isinstance(data, dict) and "x_mm" not in data:
        return _read_joints(data, where)
    return _read_place(data, where)


_POSE_KEYS = ("x_mm", "y_mm", "z_mm", "pitch_deg", "roll_deg", "yaw_deg")
_NUMBERS = numbers("^[a-z0-9_]+_(deg|mm)$")
_ANGLES: Form[Any] = Form(_write_joints, _read_angles, numbers("^[a-z0-9_]+_deg$").schema)

POSE: Form[Pose] = Form(
    pose_numbers,
    _read_pose,
    {
        "type": "object",
        "properties": dict.fromkeys(_POSE_KEYS, NUMBER.schema),
        "required": list(_POSE_KEYS[:4]),
        "additionalProperties": False,
    },
)
JOINTS: Form[Joints] = Form(_write_joints, _read_joints, _ANGLES.schema)

_PLACE: Form[Any] = Form(_write_goal, _read_place, {"anyOf": [TEXT.schema, POSE.schema]})
_AIM: Form[Any] = Form(_write_goal, _read_aim, {"anyOf": [TEXT.schema, POSE.schema, JOINTS.schema]})


# A jog in JSON: `{"move": "jog", "space": "joint", "by": {"shoulder_deg": 2}}`.


def _jog_form() -> Form[JogMove]:
    rest = record(_JogFields, {"move": "jog"}, space=_SPACE, by=_NUMBERS, frame=TEXT, speed=NUMBER)

    def write(move: JogMove) -> Json:
        jog = move.jog
        by = {f"{name}_{_unit(name)}": amount for name, amount in jog.axes}
        return rest.write(_JogFields(jog.space, by, jog.frame, move.speed))

    def read(data: Json, where: str) -> JogMove:
        found = rest.read(data, where)
        axes = jog_axes(found.by, in_steps=True)
        return JogMove(Jog(found.space, axes, found.frame), found.speed)

    return Form(write, read, rest.schema)


@dataclass(frozen=True, slots=True)
class _JogFields:
    space: Space
    by: Angles
    frame: str = BASE_FRAME
    speed: float = 0.25


def _unit(axis: str) -> str:
    return "mm" if axis in LENGTHS else "deg"


def _read_space(data: Json, where: str) -> Space:
    try:
        return Space(data)
    except ValueError:
        raise misfit(where, "joint or cartesian", data) from None


_SPACE: Form[Space] = Form(
    lambda space: space.value, _read_space, {"enum": [each.value for each in Space]}
)


# The schema of all forms.

ERROR_KEYS = ("code", "title", "message", "effect", "remedy")


def schema() -> dict[str, Json]:
    """Return the JSON schema of what armdrive reads and writes, one definition for each form."""
    status = {key: each for key, (_, each) in STATUS_FIELDS.items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "What armdrive reads and writes as JSON",
        "$defs": {
            "move": dict(move_form().schema),
            "pose": dict(POSE.schema),
            "joints": dict(JOINTS.schema),
            "status": _object(status),
            "error": _object(dict.fromkeys(ERROR_KEYS, TEXT.schema)),
        },
    }


def _object(keys: Mapping[str, Json]) -> dict[str, Json]:
    return {"type": "object", "properties": dict(keys), "required": list(keys)}
