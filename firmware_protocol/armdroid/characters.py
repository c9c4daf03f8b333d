"""The sketch's character machine: an accumulator, an argument index and the arguments it keeps.

Numbers are `int` of 16 bit, as on the AVR boards the sketch was written for, and wrap as those do.
"""

from __future__ import annotations

from firmware_protocol.armdroid.commands import (
    KEPT,
    MOTORS,
    RPM_MAX,
    DriveAll,
    DriveNone,
    DriveOne,
    HomeToOffsets,
    InterfaceKind,
    OddSpeed,
    ReportArguments,
    ReportOffsets,
    Request,
    SetSpeed,
    Torque,
    Version,
    ZeroOffsets,
)

_DIGITS = b"0123456789"
_WORD, _SIGN = 1 << 16, 1 << 15

_PLAIN: dict[int, Request] = {
    ord(request.letter): request
    for request in (
        HomeToOffsets(),
        ReportOffsets(),
        ZeroOffsets(),
        Version(),
        InterfaceKind(),
        ReportArguments(),
    )
}
_WITH_NUMBERS = frozenset(b"dDst")
MEANT = frozenset(_DIGITS) | frozenset(b"-,") | _WITH_NUMBERS | frozenset(_PLAIN)
"""Every byte that the sketch does something with."""


def wrapped(value: int) -> int:
    """Return what a signed 16-bit number makes of a value."""
    return (value + _SIGN) % _WORD - _SIGN


class Characters:
    """What the sketch remembers between characters.

    It never clears its arguments except for `r` and a new session, and `h`, `o`, `v`, `V` and `g`
    leave the accumulator as it is.
    """

    def __init__(self) -> None:
        self._arguments = [0] * KEPT
        self._index = 0
        self._accumulator = 0

    @property
    def arguments(self) -> tuple[int, ...]:
        """The five kept arguments."""
        return tuple(self._arguments)

    @property
    def accumulator(self) -> int:
        """The number that is being received."""
        return self._accumulator

    @property
    def clean(self) -> bool:
        """Whether nothing is half received: the next command means what it says."""
        return self._index == 0 and self._accumulator == 0

    def take(self, byte: int) -> Request | None:
        """Take one character; return the command that it completes, if it does."""
        if byte in _DIGITS:
            self._accumulator = wrapped(self._accumulator * 10 + byte - _DIGITS[0])
        elif byte == ord("-"):
            self._accumulator = wrapped(-self._accumulator)
        elif byte == ord(","):
            self._shift()
        elif byte in _WITH_NUMBERS:
            return self._execute(chr(byte))
        elif byte in _PLAIN:
            if byte == ord("r"):
                self.reset()
            return _PLAIN[byte]
        return None

    def reset(self) -> None:
        """Forget everything, as at the start of a session."""
        self._arguments = [0] * KEPT
        self._index = self._accumulator = 0

    def _shift(self) -> None:
        # the sixth is written behind the sketch's array of five: where it lands is not simulated
        if self._index < KEPT:
            self._arguments[self._index] = self._accumulator
        self._index = (self._index + 1) % MOTORS
        self._accumulator = 0

    def _execute(self, letter: str) -> Request:
        value, self._accumulator = self._accumulator, 0
        if letter == "t":
            return Torque(value != 0)
        if letter == "s":
            return SetSpeed(value) if 1 <= value <= RPM_MAX else OddSpeed(value)
        self._index = 0
        if letter == "D":
            return DriveAll((*self._arguments, value))
        motor = self._arguments[0] & 0xFF  # a uint8_t in the library's call
        return DriveOne(motor, value) if 1 <= motor <= MOTORS else DriveNone(motor, value)
