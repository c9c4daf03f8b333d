"""The forms of the payloads of MKS frames: nothing, a switch, a number, a choice."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, Self, TypeVar

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.mks.values import Code

Choice = TypeVar("Choice", bound=Enum)


def switch(field: str, value: object) -> bool:
    """Return True or False, or raise `BadField`."""
    if not isinstance(value, bool):
        raise BadField(field, value, "True or False")
    return value


def one_of(field: str, value: object, choices: type[Choice]) -> Choice:
    """Return a member of an enumeration, or raise `BadField`."""
    if not isinstance(value, choices):
        raise BadField(field, value, f"a {choices.__name__}")
    return value


def sized(payload: bytes, size: int) -> bytes:
    """Return a payload of that many bytes; raises `RemoteProtocolError`."""
    if len(payload) != size:
        raise RemoteProtocolError(f"{len(payload)} bytes where {size} belong")
    return payload


def byte_switch(payload: bytes) -> bool:
    """Read a byte that is 0 or 1; raises `RemoteProtocolError`."""
    (byte,) = sized(payload, 1)
    if byte > 1:
        raise RemoteProtocolError(f"{byte} where 0 or 1 belongs")
    return bool(byte)


def signed(value: int, size: int) -> bytes:
    """Return a number in that many bytes."""
    return value.to_bytes(size, "big", signed=True)


@dataclass(frozen=True, slots=True)
class Plain:
    """A code without a payload."""

    code: ClassVar[Code]

    @property
    def payload(self) -> bytes:
        """Nothing."""
        return b""

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 0)
        return cls()


@dataclass(frozen=True, slots=True)
class Switch:
    """Something that is on or off."""

    code: ClassVar[Code]
    on: bool

    def __post_init__(self) -> None:
        switch("on", self.on)

    @property
    def payload(self) -> bytes:
        """One byte."""
        return bytes((self.on,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(byte_switch(payload))


def bits(size: int) -> int:
    """Return the largest signed number of so many bytes."""
    return (1 << 8 * size - 1) - 1


def number(field: str, value: object, size: int) -> int:
    """Return a signed number that so many bytes hold, or raise `BadField`."""
    return whole(field, value, -bits(size) - 1, bits(size))
