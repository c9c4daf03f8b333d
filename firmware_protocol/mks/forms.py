"""The encoding of MKS messages: each message declares the form of its fields.

A form defines a field's valid values and their bytes. Validation, encoding and decoding of a
message all follow from the forms of its fields. A few irregular messages define their own
`payload` and `read`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any, ClassVar, Self, TypeAlias, TypeVar, get_origin, get_type_hints

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.fields import boolean
from firmware_protocol.mks.values import Ability, Code

Choice = TypeVar("Choice", bound=Enum)


@dataclass(frozen=True, slots=True)
class Form:
    """A field's size in bytes, its valid values and their encoding.

    `check` raises `BadField` for an invalid value. `unpack` takes exactly `size` bytes and raises
    ValueError if they encode no value.
    """

    size: int
    check: Callable[[str, Any], object]
    pack: Callable[[Any], bytes]
    unpack: Callable[[bytes], Any]


def unsigned(size: int, low: int = 0, high: int | None = None, unit: int = 1) -> Form:
    """Return the form of an integer from low to high, sent in multiples of a unit."""
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
    """Return the form of a signed integer, limited to -most..most if `most` is given."""
    high = (1 << 8 * size - 1) - 1 if most is None else most
    low = -high - 1 if most is None else -high
    return Form(
        size,
        lambda field, value: whole(field, value, low, high),
        lambda value: value.to_bytes(size, "big", signed=True),
        lambda data: int.from_bytes(data, "big", signed=True),
    )


def choice(kind: type[Enum]) -> Form:
    """Return the form of a member of an enumeration, sent as one byte."""
    return Form(
        1,
        lambda field, value: one_of(field, value, kind),
        lambda value: bytes((value.value,)),
        lambda data: kind(data[0]),
    )


def one_of(field: str, value: object, choices: type[Choice]) -> Choice:
    """Return the member of an enumeration for a value, or raise `BadField`."""
    if not isinstance(value, choices):
        raise BadField(field, value, f"a {choices.__name__}")
    return value


def sized(payload: bytes, *sizes: int) -> bytes:
    """Return a payload if it has one of these lengths. Raises `RemoteProtocolError`."""
    if len(payload) not in sizes:
        belong = " or ".join(map(str, sizes))
        raise RemoteProtocolError(f"{len(payload)} bytes where {belong} belong")
    return payload


def _read_switch(data: bytes) -> bool:
    if data[0] > 1:
        raise RemoteProtocolError(f"{data[0]} where 0 or 1 belongs")
    return bool(data[0])


Switch: TypeAlias = Annotated[bool, Form(1, boolean, lambda value: bytes((value,)), _read_switch)]
"""An on/off field."""


@dataclass(frozen=True, slots=True)
class _Layout:
    """The forms of a message's fields in declaration order, and each one's place in the payload."""

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
    """A request or a reading: a code, and a payload derived from the forms of its fields.

    Subclasses are frozen dataclasses. Class arguments: the `code`; the ability that a drive `needs`
    to understand the message, if some firmware lacks it; and the `order` of the fields in the
    payload, if it differs from the declaration.
    """

    __slots__ = ()
    code: ClassVar[Code]
    needs: ClassVar[Ability | None]
    order: ClassVar[tuple[str, ...]]
    _layout: ClassVar[_Layout | None] = None

    def __init_subclass__(
        cls, code: Code | None = None, needs: Ability | None = None, order: tuple[str, ...] = ()
    ) -> None:
        if code is not None:  # a slotted dataclass is created twice; keep the first values
            cls.code, cls.needs, cls.order = code, needs, order

    @classmethod
    def _laid_out(cls) -> _Layout:
        """Return the forms; cached, because a stream of commands needs them all the time."""
        if cls._layout is None:
            cls._layout = _layout_of(cls)
        return cls._layout

    def __post_init__(self) -> None:
        for name, form in self._laid_out().checked:
            form.check(name, getattr(self, name))

    @property
    def payload(self) -> bytes:
        """The bytes after the code."""
        written = self._laid_out().written
        return b"".join([form.pack(getattr(self, name)) for name, form, _ in written])

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode a payload. Raises `RemoteProtocolError`, or ValueError for an invalid value."""
        layout = cls._laid_out()
        sized(payload, layout.size)
        return cls(**{name: form.unpack(payload[at]) for name, form, at in layout.written})
