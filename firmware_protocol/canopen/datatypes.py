"""The types of CiA 301's objects: values to bytes and back, the low byte first."""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import TypeAlias

from firmware_protocol.errors import BadField, RemoteProtocolError, whole

Value: TypeAlias = bool | int | float | str | bytes
"""What an object holds: a bool, whole number, float, ASCII text, or bytes of no known meaning."""


class DataType(IntEnum):
    """A type, by its number in an object dictionary and in an EDS file."""

    BOOLEAN = 0x01
    I8 = 0x02
    I16 = 0x03
    I32 = 0x04
    U8 = 0x05
    U16 = 0x06
    U32 = 0x07
    REAL32 = 0x08
    VISIBLE_STRING = 0x09
    OCTET_STRING = 0x0A
    UNICODE_STRING = 0x0B
    TIME_OF_DAY = 0x0C
    TIME_DIFFERENCE = 0x0D
    DOMAIN = 0x0F
    I24 = 0x10
    REAL64 = 0x11
    I40 = 0x12
    I48 = 0x13
    I56 = 0x14
    I64 = 0x15
    U24 = 0x16
    U40 = 0x18
    U48 = 0x19
    U56 = 0x1A
    U64 = 0x1B

    @property
    def size(self) -> int | None:
        """How many bytes a value has; None where that differs from value to value."""
        return _SIZES.get(self)

    @property
    def bits(self) -> int | None:
        """How many bits a value has in a PDO; None where it cannot be mapped."""
        return 1 if self is DataType.BOOLEAN else None if self.size is None else 8 * self.size

    @property
    def signed(self) -> bool:
        """Whether it is a whole number with a sign."""
        return self in _SIGNED

    @property
    def limits(self) -> tuple[int, int] | None:
        """The least and the greatest whole number; None for what is none."""
        return _LIMITS.get(self)

    def pack(self, value: Value) -> bytes:
        """Return the bytes of a value; raises `BadField` for one of another type or too large."""
        if (limits := self.limits) is not None:
            number = whole(self.name, value, *limits)
            return number.to_bytes(_SIZES[self], "little", signed=self.signed)
        if self is DataType.BOOLEAN and isinstance(value, bool):
            return bytes((value,))
        if self in _REALS and isinstance(value, int | float) and not isinstance(value, bool):
            return self._pack_real(value)
        if self is DataType.VISIBLE_STRING and isinstance(value, str) and value.isascii():
            return value.encode("ascii")
        if self not in _TYPED and isinstance(value, bytes):
            return value
        raise BadField(self.name, value, _ALLOWED.get(self, "bytes"))

    def unpack(self, data: bytes, *, exact: bool = True) -> Value:
        """Return the value of bytes; raises `RemoteProtocolError`.

        Where the length is not `exact`, as in an SDO frame that did not tell it, bytes behind the
        value are left out.
        """
        size = self.size
        if size is not None and (len(data) != size if exact else len(data) < size):
            raise RemoteProtocolError(f"{len(data)} bytes where {self.name} has {size}")
        data = data[:size]
        if self.limits is not None:
            return int.from_bytes(data, "little", signed=self.signed)
        if self is DataType.BOOLEAN:
            return bool(data[0])
        if self in _REALS:
            (real,) = struct.unpack(_REALS[self], data)
            return float(real)
        if self is DataType.VISIBLE_STRING:
            return data.rstrip(b"\0").decode("ascii", "replace")
        return data

    def _pack_real(self, value: float) -> bytes:
        try:
            return struct.pack(_REALS[self], value)
        except (OverflowError, struct.error):
            raise BadField(self.name, value, "a number that it can hold") from None


_SIGNED = {
    DataType.I8: 1,
    DataType.I16: 2,
    DataType.I24: 3,
    DataType.I32: 4,
    DataType.I40: 5,
    DataType.I48: 6,
    DataType.I56: 7,
    DataType.I64: 8,
}
_UNSIGNED = {
    DataType.U8: 1,
    DataType.U16: 2,
    DataType.U24: 3,
    DataType.U32: 4,
    DataType.U40: 5,
    DataType.U48: 6,
    DataType.U56: 7,
    DataType.U64: 8,
}
_LIMITS = {
    **{kind: (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1) for kind, size in _SIGNED.items()},
    **{kind: (0, (1 << 8 * size) - 1) for kind, size in _UNSIGNED.items()},
}
_REALS = {DataType.REAL32: "<f", DataType.REAL64: "<d"}
_SIZES = {
    **_SIGNED,
    **_UNSIGNED,
    DataType.BOOLEAN: 1,
    DataType.REAL32: 4,
    DataType.REAL64: 8,
}
_TYPED = frozenset((*_SIZES, DataType.VISIBLE_STRING))
_ALLOWED = {
    DataType.BOOLEAN: "True or False",
    DataType.REAL32: "a number",
    DataType.REAL64: "a number",
    DataType.VISIBLE_STRING: "ASCII text",
}
