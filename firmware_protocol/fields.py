"""Messages whose fields are checked when they are built, with a rule for each: `@message(x=RULE)`.

A rule takes a field's name and value, and returns the value to store or raises `BadField`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any, TypeAlias, TypeVar, dataclass_transform

from firmware_protocol.errors import BadField, whole

M = TypeVar("M")
Rule: TypeAlias = Callable[[str, Any], Any]


@dataclass_transform(frozen_default=True)
def message(**rules: Rule) -> Callable[[type[M]], type[M]]:
    """Make a class a frozen, slotted dataclass that checks its fields, in the given order.

    Fields without a rule are not checked. If the class has a `__post_init__`, it runs after the
    rules and can check fields against each other.
    """

    def make(kind: Any) -> Any:
        together: Callable[[Any], None] | None = getattr(kind, "__post_init__", None)

        def check(self: Any) -> None:
            for name, rule in rules.items():
                given = getattr(self, name)
                kept = rule(name, given)
                if kept is not given:
                    object.__setattr__(self, name, kept)
            if together is not None:
                together(self)

        if rules:
            kind.__post_init__ = check
        return dataclass(frozen=True, slots=True)(kind)

    return make


def whole_from(low: int, high: int) -> Rule:
    """Return a rule that accepts integers from low to high."""
    return lambda field, value: whole(field, value, low, high)


BYTE = whole_from(0, 255)
INT16_MIN, INT16_MAX = -(1 << 15), (1 << 15) - 1
INT16 = whole_from(INT16_MIN, INT16_MAX)


def wrapped16(value: int) -> int:
    """Return a number as a counter of 16 bits holds it, signed: 32768 is -32768."""
    return (value - INT16_MIN) % (1 << 16) + INT16_MIN


def numbered(members: type[IntEnum]) -> Rule:
    """Return a rule that accepts members of an enumeration; its values must be consecutive."""
    low, high = min(members), max(members)
    return lambda field, value: members(whole(field, value, low, high))


def in_words(member: Enum) -> str:
    """Return the name of an enumeration's member for people: `FULL_SPEED` is `full speed`."""
    return member.name.replace("_", " ").lower()


def boolean(field: str, value: object) -> bool:
    """Return `value` if it is True or False, or raise `BadField`; numbers are refused."""
    if not isinstance(value, bool):
        raise BadField(field, value, "True or False")
    return value


def some_bytes(most: int, *, exactly: bool = False) -> Rule:
    """Return a rule that accepts at most, or exactly, a number of bytes."""
    allowed = f"{most} bytes" if exactly else f"at most {most} bytes"

    def rule(field: str, value: object) -> bytes:
        fits = isinstance(value, bytes) and len(value) <= most
        if not fits or not isinstance(value, bytes) or (exactly and len(value) != most):
            raise BadField(field, value, allowed)
        return value

    return rule


def an_instance(kind: type, allowed: str) -> Rule:
    """Return a rule that accepts instances of one class."""

    def rule(field: str, value: object) -> object:
        if not isinstance(value, kind):
            raise BadField(field, value, allowed)
        return value

    return rule


def optional(rule: Rule) -> Rule:
    """Return a rule that accepts None as well."""
    return lambda field, value: None if value is None else rule(field, value)


def each(rule: Rule) -> Rule:
    """Return a rule for a sequence of values, stored as a tuple."""
    return lambda field, values: tuple(rule(field, value) for value in values)


def row_of(rule: Rule, count: int | range, allowed: str) -> Rule:
    """Return a rule for a tuple or list of `count` values; `BadField` names the invalid value."""
    counts = count if isinstance(count, range) else (count,)

    def check(field: str, values: object) -> tuple[Any, ...]:
        if not isinstance(values, tuple | list) or len(values) not in counts:
            raise BadField(field, values, allowed)
        try:
            return tuple([rule(field, value) for value in values])
        except BadField:  # once more, to name the invalid one: names take longer than the rule
            return tuple(rule(f"{field}[{index}]", value) for index, value in enumerate(values))

    return check
