"""What the fields of a message can hold, stated once a field by `@checks(speed=...)`.

A rule takes a field's name and its value, and returns the value to keep, or raises `BadField`.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any, TypeAlias, TypeVar

from firmware_protocol.errors import BadField, whole

M = TypeVar("M")
Rule: TypeAlias = Callable[[str, Any], Any]


def checks(**rules: Rule) -> Callable[[type[M]], type[M]]:
    """Have the fields of a frozen message checked when it is built, in this order.

    It stands below `@dataclass`. What several fields say together is looked at behind the rules, by
    the class's own `__post_init__` if it has one.
    """

    def add(kind: type[M]) -> type[M]:
        together: Callable[[M], None] | None = getattr(kind, "__post_init__", None)

        def check(message: M) -> None:
            for name, rule in rules.items():
                given = getattr(message, name)
                kept = rule(name, given)
                if kept is not given:
                    object.__setattr__(message, name, kept)
            if together is not None:
                together(message)

        made: Any = kind
        made.__post_init__ = check
        return kind

    return add


def whole_from(low: int, high: int) -> Rule:
    """Return the rule of a whole number from low to high."""
    return lambda field, value: whole(field, value, low, high)


BYTE = whole_from(0, 255)


def numbered(members: type[IntEnum]) -> Rule:
    """Return the rule of a member of an enumeration whose numbers have no gap."""
    return lambda field, value: members(whole(field, value, min(members), max(members)))


def boolean(field: str, value: object) -> bool:
    """Return True or False, or raise `BadField`: a number is neither."""
    if not isinstance(value, bool):
        raise BadField(field, value, "True or False")
    return value


def an_instance(kind: type, allowed: str) -> Rule:
    """Return the rule of a value of one class."""

    def rule(field: str, value: object) -> object:
        if not isinstance(value, kind):
            raise BadField(field, value, allowed)
        return value

    return rule


def optional(rule: Rule) -> Rule:
    """Return the rule of a field that may be left out."""
    return lambda field, value: None if value is None else rule(field, value)


def each(rule: Rule) -> Rule:
    """Return the rule of any number of values; they are kept as a tuple."""
    return lambda field, values: tuple(rule(field, value) for value in values)


def row_of(rule: Rule, count: int | range, allowed: str) -> Rule:
    """Return the rule of a row of so many values, kept as a tuple; `BadField` names the one."""
    counts = count if isinstance(count, range) else (count,)

    def check(field: str, values: object) -> tuple[Any, ...]:
        if not isinstance(values, tuple | list) or len(values) not in counts:
            raise BadField(field, values, allowed)
        return tuple(rule(f"{field}[{index}]", value) for index, value in enumerate(values))

    return check
