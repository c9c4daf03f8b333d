"""The codes, options and units of an MKS SERVO42D/57D on CAN.

Sources: makerbase-motor/MKS-SERVO42D-57D, the CAN manuals 1.0.6 and 1.0.9 and the version notes of
its README. Multi-byte values have the high byte first. Positive is counter-clockwise, by the
manual's examples and its note on speed; the sentences above two of its examples say the opposite,
so find the sign by a small move.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, IntEnum
from typing import Annotated, Any, ClassVar, Self, TypeAlias, TypeVar, get_origin, get_type_hints

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.fields import boolean, message

BROADCAST = 0
NODE_MAX = 0x7FF
# The factory id of every drive.
NODE_DEFAULT = 1
# Encoder counts per turn: the unit of targets (F5).
COUNTS_PER_TURN = 0x4000
# Counts per second at 1 rpm.
COUNTS_S_PER_RPM = COUNTS_PER_TURN / 60.0
ANGLE_ERROR_PER_TURN = 51200
SPEED_MAX_RPM = 3000
# Above this speed the manual advises against stops without a ramp: F7, or an acc of 0.
HARD_STOP_MAX_RPM = 1000
# The farthest target or distance: 512 turns in counts.
TARGET_MAX = (1 << 23) - 1


class Code(IntEnum):
    """The first byte of a frame's data; the answer repeats it."""

    READ_SETTING = 0x00
    ENCODER = 0x31
    RAW_ENCODER = 0x35
    ANGLE_ERROR = 0x39
    ENABLED = 0x3A
    HOMING_STATE = 0x3B
    CLEAR_STALL = 0x3D
    STALL = 0x3E
    VERSION = 0x40
    ARM = 0x4A
    GO = 0x4B
    CALIBRATE = 0x80
    MODE = 0x82
    CURRENT = 0x83
    MICROSTEPS = 0x84
    STALL_PROTECTION = 0x88
    BITRATE = 0x8A
    NODE = 0x8B
    REPLIES = 0x8C
    HOMING = 0x90
    HOME = 0x91
    ZERO = 0x92
    WATCHDOG = 0x98
    STATE = 0xF1
    ENABLE = 0xF3
    RELATIVE_AXIS = 0xF4
    ABSOLUTE_AXIS = 0xF5
    SPEED_MODE = 0xF6
    EMERGENCY_STOP = 0xF7
    RELATIVE_PULSES = 0xFD
    ABSOLUTE_PULSES = 0xFE


class Mode(IntEnum):
    """The source of commands, and the kind of control. F1 to FE work only in the bus modes."""

    PULSE_OPEN = 0
    PULSE_CLOSED = 1
    PULSE_FOC = 2
    """The factory setting."""
    BUS_OPEN = 3
    BUS_CLOSED = 4
    BUS_FOC = 5
    """The mode that an arm needs."""

    @property
    def on_bus(self) -> bool:
        """Whether motions are commanded over the bus."""
        return self >= Mode.BUS_OPEN

    @property
    def title(self) -> str:
        """Its number, and its name in the drive's menu."""
        return f"{int(self)} ({MENU_NAMES[self]})"

    @property
    def top_rpm(self) -> int:
        """The mode's highest speed, from the manual."""
        return (400, 1500, SPEED_MAX_RPM)[self % 3]


# The modes in the drive's menu: CR are for pulses, SR for the bus.
MENU_NAMES = ("CR_OPEN", "CR_CLOSE", "CR_vFOC", "SR_OPEN", "SR_CLOSE", "SR_vFOC")


class Bitrate(IntEnum):
    """The bus's speed."""

    K125 = 0
    K250 = 1
    K500 = 2
    """The factory setting."""
    K1000 = 3

    @property
    def bits_s(self) -> int:
        """Bits per second."""
        return 125_000 << self


class ReplyMode(Enum):
    """Which replies a drive sends to commands.

    The manual implies that the drive answers reads in every mode: without replies to commands,
    the host has to follow the drive by reading its state.
    """

    NONE = b"\0\0"
    IMMEDIATE = b"\1\0"
    """A reply to the command (started or failed), none at the end of a motion."""
    FULL = b"\1\1"
    """A reply to the command and another at the end. The factory setting."""


class MotorState(IntEnum):
    """The motor's state."""

    UNKNOWN = 0
    """The drive could not determine it."""
    STOPPED = 1
    ACCELERATING = 2
    DECELERATING = 3
    FULL_SPEED = 4
    HOMING = 5
    CALIBRATING = 6


class HomingState(IntEnum):
    """The state of a return to zero."""

    UNDER_WAY = 0
    DONE = 1
    FAILED = 2


class Outcome(Enum):
    """The outcome of a request other than a read."""

    STARTED = "started"
    DONE = "done"
    FAILED = "failed"
    LIMIT_STOP = "stopped by a limit switch"
    STORED = "stored for the synchronous start"


def check_byte(can_id: int, data: bytes) -> int:
    """Return a frame's last byte: the sum of its id and all preceding bytes, modulo 256.

    The sum detects every change of a single byte, but no swapped bytes, no changes that cancel out
    and no ids that differ by 256. On the bus, CAN's own CRC protects the frame as well.
    """
    return (can_id + sum(data)) & 0xFF


def ramp_rpm_s(acc: int) -> float:
    """Return the acceleration of an `acc` in rpm per second; infinity for 0, which has no ramp.

    The speed changes by 1 rpm every (256 - acc) * 50 microseconds.
    """
    whole("acc", acc, 0, 255)
    return 20_000 / (256 - acc) if acc else math.inf


def slope_of(acc: int) -> float:
    """Return the acceleration of an `acc` in counts/s²; infinity for 0, which has no ramp."""
    return ramp_rpm_s(acc) * COUNTS_S_PER_RPM


def acc_of(most_rpm_s: float) -> int:
    """Return the steepest `acc` within a limit in rpm per second.

    The gentlest ramp is `acc` 1 with 78 rpm per second, returned even if it exceeds the limit;
    `ramp_rpm_s` gives the resulting acceleration.
    """
    return max(1, 256 - max(1, math.ceil(20_000 / most_rpm_s)))


def true_rpm(speed_rpm: float, microsteps: int) -> float:
    """Return the shaft's true speed; a speed is in rpm only with 16, 32 or 64 microsteps."""
    return speed_rpm if microsteps in (16, 32, 64) else speed_rpm * 16 / microsteps


# What each firmware of an MKS SERVO42D/57D on CAN can do: one table.
#
# Requests say themselves which ability they need.
#
# Versions are those of the README's version notes (makerbase-motor/MKS-SERVO42D-57D), where not
# marked otherwise. A drive reports its version from some firmware on; what does not answer
# `ReadVersion` is older, or not there.

Version: TypeAlias = tuple[int, int, int]


class Ability(Enum):
    """Something that not every firmware can do, with the first version that can."""

    since: Version

    def __new__(cls, words: str, since: Version) -> Self:
        """Make a member whose value is its description."""
        one = object.__new__(cls)
        one._value_, one.since = words, since
        return one

    ZERO = "set the zero", (1, 0, 1)
    EMERGENCY_STOP = "emergency stop", (1, 0, 4)
    CHOICE_OF_COMPLETION = "two bytes in 8C: no replies at the end of a motion", (1, 0, 4)
    RETARGET = "an F5 replaces the one that is under way", (1, 0, 5)
    READ_SETTINGS = "read settings", (1, 0, 6)
    RAW_ENCODER = "read the raw encoder", (1, 0, 6)
    HOMING_BY_COMMAND_READ = "read the state of a commanded homing", (1, 0, 7)
    SYNCHRONOUS_START = "synchronous start", (1, 0, 8)
    ARRIVAL = "a motion is done only when the shaft has arrived", (1, 0, 8)
    # in the manual 1.0.9, not in that of 1.0.6, and in no version note
    VERSION = "read the version", (1, 0, 8)
    SILENCE_WATCHDOG = "silence watchdog", (1, 0, 9)


# The newest firmware that this table knows of.
LATEST: Version = (1, 0, 9)


def abilities_of(version: Version) -> frozenset[Ability]:
    """Return what a firmware can do; one newer than `LATEST` what `LATEST` can."""
    return frozenset(ability for ability in Ability if version >= ability.since)


# The encoding of messages: each message declares the forms of its fields.
#
# Validation, encoding and decoding of a message all follow from these forms. A few irregular
# messages define their own `payload` and `read`.

Choice = TypeVar("Choice", bound=Enum)


@message()
class Form:
    """A field's size in bytes, its valid values and their encoding.

    `check` raises `BadField` for an invalid value. `unpack` takes exactly `size` bytes and raises
    ValueError if they encode no value.
    """

    size: int
    check: Callable[[str, Any], object]
    pack: Callable[[Any], bytes]
    unpack: Callable[[bytes], Any]


def unsigned(size: int, low: int = 0, high: int | None = None) -> Form:
    """Return the form of an integer from low to high."""
    most = (1 << 8 * size) - 1 if high is None else high
    return Form(
        size,
        lambda field, value: whole(field, value, low, most),
        lambda value: value.to_bytes(size, "big"),
        lambda data: int.from_bytes(data, "big"),
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
        raise RemoteProtocolError(f"length {len(payload)} where {belong} belong")
    return payload


def _read_switch(data: bytes) -> bool:
    if data[0] > 1:
        raise RemoteProtocolError(f"{data[0]} where 0 or 1 belongs")
    return bool(data[0])


# An on/off field.
Switch: TypeAlias = Annotated[bool, Form(1, boolean, lambda value: bytes((value,)), _read_switch)]


@message()
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
