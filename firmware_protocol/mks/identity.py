"""What an MKS drive says of itself: its version, and how it is set up; checked when built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.mks.forms import one_of, switch
from firmware_protocol.mks.values import Code

BOARDS = {
    1: "SERVO42D, RS485",
    2: "SERVO42D, CAN",
    3: "SERVO57D, RS485",
    4: "SERVO57D, CAN",
    5: "SERVO28D, RS485",
    6: "SERVO28D, CAN",
    7: "SERVO35D, RS485",
    8: "SERVO35D, CAN",
}
"""What the number of a board means, by the manual 1.0.9."""

_UNREADABLE = b"\xff\xff"


@dataclass(frozen=True, slots=True)
class VersionRead:
    """Whether the encoder is calibrated, the board's number, and the firmware.

    The firmware has three numbers by what public programs read and two bytes by the manual 1.0.9,
    which does not say how to read those: `version` is None for them.
    """

    code: ClassVar[Code] = Code.VERSION
    calibrated: bool
    board: int
    firmware: bytes

    def __post_init__(self) -> None:
        switch("calibrated", self.calibrated)
        whole("board", self.board, 0, 0x0F)
        if not isinstance(self.firmware, bytes) or len(self.firmware) not in (2, 3):
            raise BadField("firmware", self.firmware, "two or three bytes")

    @property
    def version(self) -> tuple[int, int, int] | None:
        """The version, as `abilities_of` takes it."""
        return None if len(self.firmware) < 3 else (*self.firmware[:2], self.firmware[2])

    @property
    def payload(self) -> bytes:
        """Calibration and board in one byte, firmware."""
        return bytes((self.calibrated << 4 | self.board,)) + self.firmware

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        if len(payload) not in (3, 4):
            raise RemoteProtocolError(f"{len(payload)} bytes where 3 or 4 belong")
        return cls(payload[0] > 0x0F, payload[0] & 0x0F, payload[1:])


@dataclass(frozen=True, slots=True)
class SettingRead:
    """A setting's payload as it is set, or None where the drive does not tell it."""

    code: Code
    value: bytes | None

    def __post_init__(self) -> None:
        one_of("code", self.code, Code)
        fits = isinstance(self.value, bytes) and 1 <= len(self.value) <= 6
        if self.value is not None and (not fits or self.value == _UNREADABLE):
            raise BadField("value", self.value, "1 to 6 bytes other than FF FF, or None")

    @property
    def payload(self) -> bytes:
        """The value, or FF FF."""
        return _UNREADABLE if self.value is None else self.value

    @classmethod
    def of(cls, code: Code, payload: bytes) -> Self:
        """Read a payload."""
        return cls(code, None if payload == _UNREADABLE else payload)
