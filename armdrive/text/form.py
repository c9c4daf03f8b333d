"""How values are written as JSON: one description writes, reads, checks and gives the schema.

A `Form` belongs to one type of values. Whatever does not fit raises `BadArgument`, which says where
in the JSON it stands, what belongs there and what was found instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any, Generic, TypeVar

from armdrive.errors import ArmError, BadArgument
from armdrive.errors.kinematic import checked_number, refusal_of
from kinematics.errors import KinematicsError, suggestion

T = TypeVar("T")

Json = Any
"""Plain data: what `json.loads` returns."""


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


NUMBER: Form[float] = Form(float, _number, {"type": "number"})
TEXT: Form[str] = Form(str, _text, {"type": "string"})


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


def numbers(names: str) -> Form[Mapping[str, float]]:
    """Return the form of numbers by names, which match a pattern."""
    return Form(
        lambda values: {name: float(value) for name, value in values.items()},
        lambda data, where: {
            name: _number(value, f"{where}.{name}") for name, value in as_table(data, where).items()
        },
        {
            "type": "object",
            "patternProperties": {names: NUMBER.schema},
            "additionalProperties": False,
            "minProperties": 1,
        },
    )


def as_table(data: Json, where: str) -> Mapping[str, Json]:
    """Return a JSON object. Raises `BadArgument` for anything else."""
    if not isinstance(data, dict):
        raise misfit(where, "an object", data)
    return data


Fields = Mapping[str, Form[Any]]
"""The forms of a dataclass's fields."""


def record(kind: type[T], tag: Mapping[str, str] | None = None, /, **forms: Form[Any]) -> Form[T]:
    """Return the form of a dataclass: an object with a key for each field.

    A field that has a default may be missing. `tag` is written besides, and tells kinds apart.
    """
    tags = tag or {}
    needed = [
        each.name
        for each in fields(kind)  # type: ignore[arg-type]
        if each.name in forms and each.default is MISSING
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


def tagged(key: str, kinds: Mapping[str, tuple[type, Fields | Form[Any]]]) -> Form[Any]:
    """Return the form of values of several classes: the object's `key` says which one it is.

    For each class, `kinds` has the forms of its fields, or its whole form where that is another.
    """
    forms = {
        tag: (kind, each if isinstance(each, Form) else record(kind, {key: tag}, **each))
        for tag, (kind, each) in kinds.items()
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
