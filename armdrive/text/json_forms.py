"""The JSON forms that every output and input shares: moves, poses, joint angles, status, errors.

`--json`, the recorder, the journals and the control socket all use these forms: mm and degrees,
with the unit in the key.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from types import NoneType
from typing import Any, Generic, TypeVar, get_args, get_origin, get_type_hints

from armdrive.errors import ArmError, BadArgument
from armdrive.errors.kinematic import checked_number, refusal_of
from armdrive.errors.table import error_view
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
    SingleMove,
    Space,
    jog_axes,
)
from armdrive.status import STATUS_FIELDS, joints_numbers, pose_numbers
from kinematics.errors import KinematicsError, suggestion
from kinematics.paths.routes import ArcPart, JointPart, LinePart, PathPart, PosePart
from kinematics.spaces import COORDINATES, Joints, Pose

T = TypeVar("T")

# Plain data: what `json.loads` returns.
Json = Any


# A `Form` belongs to one type of values: one description writes, reads, checks and gives the
# schema. Whatever does not fit raises `BadArgument`, which says where in the JSON it stands, what
# belongs there and what was found instead.


@dataclass(frozen=True, slots=True, eq=False)
class Form(Generic[T]):
    """How values of one type are written as JSON.

    `read` takes the data and where it stands, for the error.
    """

    write: Callable[[T], Json]
    read: Callable[[Json, str], T]
    schema: Mapping[str, Json]


def misfit(where: str, expected: str, found: object) -> BadArgument:
    """Return the error of data that does not fit."""
    return BadArgument(f"{where} must be {expected}, not {found!r:.80}")


def _number(data: Json, where: str) -> float:
    if isinstance(data, bool) or not isinstance(data, int | float):
        raise misfit(where, "a number", data)
    return checked_number(where, data)


def _text(data: Json, where: str) -> str:
    if not isinstance(data, str):
        raise misfit(where, "text", data)
    return data


def _whole(data: Json, where: str) -> int:
    if type(data) is not int:
        raise misfit(where, "a whole number", data)
    return data


NUMBER: Form[float] = Form(float, _number, {"type": "number"})
TEXT: Form[str] = Form(str, _text, {"type": "string"})
WHOLE: Form[int] = Form(int, _whole, {"type": "integer"})


def optional(form: Form[T]) -> Form[T | None]:
    """Return the form of values that may be missing, which is `null`."""
    return Form(
        lambda value: None if value is None else form.write(value),
        lambda data, where: None if data is None else form.read(data, where),
        {"anyOf": [form.schema, {"type": "null"}]},
    )


def several(form: Form[T]) -> Form[tuple[T, ...]]:
    """Return the form of several values, in a list."""

    def read(data: Json, where: str) -> tuple[T, ...]:
        if not isinstance(data, list):
            raise misfit(where, "a list", data)
        return tuple(form.read(each, f"{where}[{index}]") for index, each in enumerate(data))

    return Form(
        lambda values: [form.write(value) for value in values],
        read,
        {"type": "array", "items": form.schema},
    )


def by_name(form: Form[T], names: str = ".*") -> Form[dict[str, T]]:
    """Return the form of values by their names, which match a pattern."""
    return Form(
        lambda values: {name: form.write(value) for name, value in values.items()},
        lambda data, where: {
            name: form.read(value, f"{where}.{name}")
            for name, value in as_table(data, where).items()
        },
        {
            "type": "object",
            "patternProperties": {names: form.schema},
            "additionalProperties": False,
            "minProperties": 1,
        },
    )


def as_table(data: Json, where: str) -> Mapping[str, Json]:
    """Return a JSON object. Raises `BadArgument` for anything else."""
    if not isinstance(data, dict):
        raise misfit(where, "an object", data)
    return data


def record(kind: type[T], tag: Mapping[str, str] | None = None, /, **forms: Form[Any]) -> Form[T]:
    """Return the form of a dataclass: an object with a key for each field.

    A field's form is that of its annotation, unless `forms` has another one. A field that has a
    default may be missing. `tag` is written as well, and distinguishes kinds.
    """
    tags = tag or {}
    names = [each.name for each in fields(kind)]  # type: ignore[arg-type]
    if not forms.keys() >= set(names):
        hints = get_type_hints(kind)
        forms = {name: forms.get(name) or form_of(hints[name]) for name in names}
    needed = [
        each.name
        for each in fields(kind)  # type: ignore[arg-type]
        if each.default is MISSING
    ]

    def read(data: Json, where: str) -> T:
        given = {name: each for name, each in as_table(data, where).items() if name not in tags}
        if missing := [name for name in needed if name not in given]:
            raise BadArgument(f"{where} has no {missing[0]!r}")
        if strange := [name for name in given if name not in forms]:
            hint = suggestion(strange[0], tuple(forms))
            raise BadArgument(
                f"{where} has a key {strange[0]!r:.40}; known are {', '.join(forms)}{hint}"
            )
        values = {name: forms[name].read(each, f"{where}.{name}") for name, each in given.items()}
        try:
            return kind(**values)
        except ArmError:
            raise
        except KinematicsError as error:
            raise refusal_of(error) from None

    schema = {
        "type": "object",
        "properties": {
            **{name: {"const": value} for name, value in tags.items()},
            **{name: form.schema for name, form in forms.items()},
        },
        "required": [*tags, *needed],
        "additionalProperties": False,
    }
    return Form(
        lambda value: {
            **tags,
            **{name: form.write(getattr(value, name)) for name, form in forms.items()},
        },
        read,
        schema,
    )


def tagged(key: str, kinds: Mapping[str, type]) -> Form[Any]:
    """Return the form of values of several classes: the object's `key` says which one it is."""
    forms: dict[str, tuple[type, Form[Any]]] = {
        tag: (kind, _jog_form() if kind is JogMove else record(kind, {key: tag}))
        for tag, kind in kinds.items()
    }
    by_class = dict(forms.values())

    def write(value: object) -> Json:
        if type(value) not in by_class:
            known = ", ".join(kind.__name__ for kind in by_class)
            raise BadArgument(f"{value!r:.80} cannot be written as JSON: it is none of {known}")
        return by_class[type(value)].write(value)

    def read(data: Json, where: str) -> object:
        tag = as_table(data, where).get(key)
        if not isinstance(tag, str) or tag not in forms:
            hint = suggestion(tag, forms) if isinstance(tag, str) else ""
            expected = f"one of {', '.join(forms)}"
            raise BadArgument(f"{where}.{key} must be {expected}, not {tag!r:.40}{hint}")
        return forms[tag][1].read(data, where)

    return Form(write, read, {"oneOf": [form.schema for _, form in forms.values()]})


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
    return tagged("move", {**_SINGLE, "sequence": MoveSequence})


_SINGLE = {
    "joint": JointMove,
    "pose": PoseMove,
    "line": LineMove,
    "arc": ArcMove,
    "path": PathMove,
    "gripper": GripperMove,
    "grasp": GraspMove,
    "park": ParkMove,
    "jog": JogMove,
}
_PARTS = {"joint": JointPart, "pose": PosePart, "line": LinePart, "arc": ArcPart}


@functools.cache
def form_of(kind: Any) -> Form[Any]:
    """Return the form of the values that an annotation allows."""
    known: dict[Any, Form[Any]] = {
        float: NUMBER,
        int: WHOLE,
        str: TEXT,
        Pose: POSE,
        Joints: JOINTS,
        Joints | Angles: _ANGLES,
        Pose | str: _PLACE,
        Pose | Joints | str: _AIM,
    }
    inner = get_args(kind)
    if kind in known:
        return known[kind]
    if kind == PathPart:
        return tagged("part", _PARTS)
    if kind == SingleMove:
        return tagged("move", _SINGLE)
    if get_origin(kind) is Sequence:
        return several(form_of(inner[0]))
    if NoneType in inner:
        return optional(form_of(inner[0]))
    return record(kind)


# Poses and joint angles in JSON: mm and degrees, with the keys that every other output has.


def _read_pose(data: Json, where: str) -> Pose:
    given = _NUMBERS.read(data, where)
    if missing := [key for key in COORDINATES[:4] if key not in given]:
        raise BadArgument(f"{where} has no {missing[0]!r}")
    if strange := [key for key in given if key not in COORDINATES]:
        known = ", ".join(COORDINATES)
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


_NUMBERS = by_name(NUMBER, "^[a-z0-9_]+_(deg|mm)$")
_ANGLES: Form[Any] = Form(_write_joints, _read_angles, by_name(NUMBER, "^[a-z0-9_]+_deg$").schema)

POSE: Form[Pose] = Form(
    pose_numbers,
    _read_pose,
    {
        "type": "object",
        "properties": dict.fromkeys(COORDINATES, NUMBER.schema),
        "required": list(COORDINATES[:4]),
        "additionalProperties": False,
    },
)
JOINTS: Form[Joints] = Form(_write_joints, _read_joints, _ANGLES.schema)

_PLACE: Form[Any] = Form(_write_goal, _read_place, {"anyOf": [TEXT.schema, POSE.schema]})
_AIM: Form[Any] = Form(_write_goal, _read_aim, {"anyOf": [TEXT.schema, POSE.schema, JOINTS.schema]})


# A jog in JSON: `{"move": "jog", "space": "joint", "by": {"shoulder_deg": 2}}`.


def _jog_form() -> Form[JogMove]:
    rest = record(_JogFields, {"move": "jog"}, space=_SPACE, by=_NUMBERS)

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
            "error": _object(dict.fromkeys(error_view(BadArgument("")), TEXT.schema)),
        },
    }


def _object(keys: Mapping[str, Json]) -> dict[str, Json]:
    return {"type": "object", "properties": dict(keys), "required": list(keys)}
