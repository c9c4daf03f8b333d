"""What differs between the boards of an Armdroid, and what the sketch makes of a speed.

Source: Armdroid/Armdroid-Arduino-Library, Armdroid.cpp (setSpeed, the order of the channels).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

CHANNELS = (6, 5, 4, 3, 2, 1)
"""The channel of each motor: base, shoulder, elbow, right and left wrist, gripper."""
MINUTE_MS, TURN_STEPS = 60_000, 48
AT_ONCE_S = 0.0004
"""Between two steps of all motors, when the sketch waits for nothing."""
NEVER_S = 4_294_967.295
"""What a division by zero makes of the interval on an AVR: the greatest number of 32 bit, in ms."""


@dataclass(frozen=True, slots=True)
class Board:
    """What differs between boards.

    `character_s` is how long a character takes, `room_bytes` how many wait at most, `boot_s` how
    long a reset lasts. A board with native USB `greets` whoever opens its port; another
    `resets_on_open`. `speed_error` 0.2 makes motions a fifth longer.
    """

    character_s: float = 0.010
    room_bytes: int = 63
    boot_s: float = 1.6
    greets: bool = True
    resets_on_open: bool = False
    speed_error: float = 0.0

    def interval_s(self, rpm: int) -> float:
        """Return the time between two steps: whole milliseconds, by a division without a rest."""
        if rpm == 0:
            return NEVER_S
        interval_s = MINUTE_MS // TURN_STEPS // (rpm % (1 << 32)) / 1000.0
        return max(interval_s, AT_ONCE_S) * (1.0 + self.speed_error)


def by_channel(by_motor: Sequence[int]) -> tuple[int, ...]:
    """Return counts in the order of the channels."""
    return tuple(by_motor[CHANNELS.index(channel)] for channel in range(1, len(CHANNELS) + 1))


def by_motor(by_channel: Sequence[int]) -> tuple[int, ...]:
    """Return counts in the order of the arm's motors."""
    return tuple(by_channel[channel - 1] for channel in CHANNELS)
