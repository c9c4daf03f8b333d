"""How MKS messages are written: a message declares the form of each of its fields.

A form says which values fit, and which bytes they are. What a message refuses, its payload, and
how a payload is read all follow from the forms of its fields, so that none of them is written
down for a message by itself. A few that are irregular write and read their payload on their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any, ClassVar, Self, TypeAlias, TypeVar, get_origin, get_type_hints

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.mks.values import Ability, Code

Choice = TypeVar("Choice", bound=Enum)


@dataclass(frozen=True, slots=True)
class Form:
    """What a field may be, and how it is written in so many bytes.

    `check` raises `BadField` for a value that does not fit. `unpack` raises ValueError for bytes
    that are no value; it is handed as many as there should be.
    """

    size: int
    check: Callable[[str, Any], object]
    pack: Callable[[Any], bytes]
    unpack: Callable[[bytes], Any]


def unsigned(size: int, low: int = 0, high: int | None = None, unit: int = 1) -> Form:
    """Return the form of a whole number from low to high, written in multiples of a unit."""
    most = (1 << 8 * size) - 1 if high is None else high

    def check(field: str, value: object) -> None:
        if whole(field, value, low, most) % unit:
            raise BadField(field, value, f"a multiple of {unit}")

    return Form(
        size,
        check,
        lambda value: (value // unit).to_bytes(size, "big"),
        lambda data: int.from_bytes(data, "big") * unit,
    )


def signed(size: int, most: int | None = None) -> Form:
    """Return the form of a number with a sign, at most `most` either way where that is told."""
    high = (1 << 8 * size - 1) - 1 if most is None else most
    low = -high - 1 if most is None else -high
    return Form(
        size,
        lambda field, value: whole(field, value, low, high),
        lambda value: value.to_bytes(size, "big", signed=True),
        lambda data: int.from_bytes(data, "big", signed=True),
    )


def choice(kind: type[Enum]) -> Form:
    """Return the form of a member of an enumeration of bytes."""
    return Form(
        1,
        lambda field, value: one_of(field, value, kind),
        lambda value: bytes((value.value,)),
        lambda data: kind(data[0]),
    )


def one_of(field: str, value: object, choices: type[Choice]) -> Choice:
    """Return a member of an enumeration, or raise `BadField`."""
    if not isinstance(value, choices):
        raise BadField(field, value, f"a {choices.__name__}")
    return value


def switch(field: str, value: object) -> bool:
    """Return True or False, or raise `BadField`."""
    if not isinstance(value, bool):
        raise BadField(field, value, "True or False")
    return value


def sized(payload: bytes, *sizes: int) -> bytes:
    """Return a payload of one of these lengths; raises `RemoteProtocolError`."""
    if len(payload) not in sizes:
        belong = " or ".join(map(str, sizes))
        raise RemoteProtocolError(f"{len(payload)} bytes where {belong} belong")
    return payload


def _read_switch(data: bytes) -> bool:
    if data[0] > 1:
        raise RemoteProtocolError(f"{data[0]} where 0 or 1 belongs")
    return bool(data[0])


Switch: TypeAlias = Annotated[bool, Form(1, switch, lambda value: bytes((value,)), _read_switch)]
"""Something that is on or off."""


@dataclass(frozen=True, slots=True)
class _Layout:
    """The forms of a message's fields: in the order of its fields, and where each is written."""

    checked: tuple[tuple[str, Form], ...]
    written: tuple[tuple[str, Form, slice], ...]
    size: int


def _layout_of(message: type[Message]) -> _Layout:
    hints = get_type_hints(message, include_extras=True)
    forms = {
        name: hint.__metadata__[0] for name, hint in hints.items() if get_origin(hint) is Annotated
    }
    written, at = [], 0
    for name in message.order or forms:
        written.append((name, forms[name], slice(at, at + forms[name].size)))
        at += forms[name].size
    return _Layout(tuple(forms.items()), tuple(written), at)


class Message:
    """A request or a reading: a code, and a payload that follows from the forms of its fields.

    A subclass is a frozen dataclass. It is given its `code`, what a drive `needs` to understand it
    where not every firmware does, and the `order` in which its fields are written where that is
    another one.
    """

    __slots__ = ()
    code: ClassVar[Code]
    needs: ClassVar[Ability | None]
    order: ClassVar[tuple[str, ...]]
    _layout: ClassVar[_Layout | None] = None

    def __init_subclass__(
        cls, code: Code | None = None, needs: Ability | None = None, order: tuple[str, ...] = ()
    ) -> None:
        if code is not None:  # a dataclass with slots is made twice, and keeps this then
            cls.code, cls.needs, cls.order = code, needs, order

    @classmethod
    def _laid_out(cls) -> _Layout:
        """Return the forms, worked out once: a stream of orders asks for them again and again."""
        if cls._layout is None:
            cls._layout = _layout_of(cls)
        return cls._layout

    def __post_init__(self) -> None:
        for name, form in self._laid_out().checked:
            form.check(name, getattr(self, name))

    @property
    def payload(self) -> bytes:
        """What follows its code."""
        written = self._laid_out().written
        return b"".join([form.pack(getattr(self, name)) for name, form, _ in written])

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload. Raises `RemoteProtocolError`, or ValueError for what no value is."""
        layout = cls._laid_out()
        sized(payload, layout.size)
        return cls(**{name: form.unpack(payload[at]) for name, form, at in layout.written})
