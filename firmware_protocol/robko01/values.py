"""The small values of the SUPER protocol: operations, status, the six axes, positions that wrap.

Operations and status: robko01/fw_arduino_lib src/OperationsCodes.h and src/SUPER.h.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

from firmware_protocol.errors import BadField, whole

AXES = 6
AXIS_NAMES = ("base", "shoulder", "elbow", "left differential", "right differential", "gripper")
WORD_MIN, WORD_MAX = -(1 << 15), (1 << 15) - 1
_TURN = 1 << 16
_TWELVE = struct.Struct(f"<{2 * AXES}h")
AXES_BYTES = _TWELVE.size


class Op(IntEnum):
    """What a request asks for; its answer carries the same number."""

    PING = 1
    STOP = 2
    DISABLE = 3
    ENABLE = 4
    CLEAR = 5
    MOVE_RELATIVE = 6
    MOVE_ABSOLUTE = 7
    OUTPUTS = 8
    INPUTS = 9
    IS_MOVING = 10
    POSITION = 11
    MOVE_SPEED = 12
    SET_ROBOT_ID = 13
    GET_ROBOT_ID = 14
    SAVE_POSITION = 15
    LOAD_POSITION = 16


class Status(IntEnum):
    """How a request fared."""

    OK = 1
    ERROR = 2
    """Refused; a move is while the motors are disabled."""
    BUSY = 3
    """Refused: the arm is moving."""
    TIMEOUT = 4


def six_words(field: str, words: object) -> tuple[int, ...]:
    """Return six whole numbers in signed 16 bit, or raise `BadField` naming the one."""
    if not isinstance(words, tuple | list) or len(words) != AXES:
        raise BadField(field, words, f"{AXES} whole numbers, one an axis")
    return tuple(
        whole(f"{field}[{index}]", word, WORD_MIN, WORD_MAX) for index, word in enumerate(words)
    )


@dataclass(frozen=True, slots=True)
class Axes:
    """A position in steps and a speed in steps a second for each axis, base to gripper.

    In a move the position is where to go, or how far; in an answer where the axis is, and both
    have wrapped to 16 bits. Raises `BadField`.
    """

    positions_steps: tuple[int, ...]
    speeds_steps_s: tuple[int, ...] = (0,) * AXES

    def __post_init__(self) -> None:
        for field in ("positions_steps", "speeds_steps_s"):
            object.__setattr__(self, field, six_words(field, getattr(self, field)))

    @classmethod
    def from_bytes(cls, data: bytes) -> Axes:
        """Read the 24 bytes: position, speed, position, speed, ..., low byte first."""
        words = _TWELVE.unpack(data)
        return cls(words[::2], words[1::2])

    def to_bytes(self) -> bytes:
        """Return the 24 bytes."""
        pairs = zip(self.positions_steps, self.speeds_steps_s, strict=True)
        return _TWELVE.pack(*(word for pair in pairs for word in pair))


def wrap(position_steps: int) -> int:
    """Return a position as the arm reports it: in 16 bits, wrapped."""
    return (position_steps - WORD_MIN) % _TURN + WORD_MIN


def unwrap(reported_steps: int, near_steps: int) -> int:
    """Return the position nearest to a known one among those that are reported alike.

    Right as long as the axis is less than 32768 steps from where it is believed to be.
    """
    return near_steps + wrap(reported_steps - near_steps)
