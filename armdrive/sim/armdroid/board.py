"""The boards of an Armdroid: what differs between them, and how they turn their steppers.

Source: Armdroid/Armdroid-Arduino-Library, Armdroid.cpp (setSpeed, the order of the channels).
"""

from __future__ import annotations

import math
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
class ArmdroidBoard:
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


# --- The steppers: all at one rate, each until its own steps are made ----------------------------
#
# Steps, seconds. The board looks at its clock all the time and steps every motor that has steps
# left as soon as the interval since the last step is over, so a motion begins with a step at once.

_ROUNDING = 1e-6
"""The share of an interval that may be missing through floating-point rounding."""


class LockstepRack:
    """The counts of all motors, and the motion under way."""

    def __init__(self, counts: Sequence[int]) -> None:
        self._counts = tuple(counts)
        self._deltas: tuple[int, ...] | None = None
        self._interval_s = 1.0
        self._first_s = 0.0
        self.last_step_s = -math.inf

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and nobody has called `settle` since."""
        return self._deltas is not None

    @property
    def done_s(self) -> float:
        """When the last step is made; infinity while no motion is under way."""
        if self._deltas is None:
            return math.inf
        return self._step_s(max(map(abs, self._deltas)))

    def start(self, deltas: Sequence[int], interval_s: float, now_s: float) -> None:
        """Begin to turn each motor by its own steps."""
        self.stop(now_s)
        self._deltas, self._interval_s = tuple(deltas), interval_s
        self._first_s = max(now_s, self.last_step_s + interval_s) if any(deltas) else now_s

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        if self._deltas is None:
            return self._counts
        made = self._made(now_s)
        return tuple(
            count + max(-made, min(delta, made))
            for count, delta in zip(self._counts, self._deltas, strict=True)
        )

    def bends(self, start_s: float, end_s: float) -> list[float]:
        """Return when motors fall out of step, one by one."""
        ends = sorted({self._step_s(abs(delta)) for delta in self._deltas or () if delta})
        return [end for end in ends if start_s < end < end_s]

    def settle(self, now_s: float) -> None:
        """Take in a motion that has ended."""
        if self.done_s <= now_s:
            self.stop(now_s)

    def stop(self, now_s: float) -> None:
        """End the motion dead where it is now."""
        self._counts = self.positions(now_s)
        if made := self._made(now_s):
            self.last_step_s = self._step_s(made)
        self._deltas = None

    def count(self, deltas: Sequence[int]) -> None:
        """Count steps that were made apart from any motion."""
        self._counts = tuple(a + b for a, b in zip(self._counts, deltas, strict=True))

    def zero(self) -> None:
        """Begin to count anew; nothing turns."""
        self._counts = (0,) * len(self._counts)
        self._deltas = None

    def _step_s(self, number: int) -> float:
        """Return when a step is made, the first being number 1; number 0 is made at once."""
        return self._first_s + max(number - 1, 0) * self._interval_s

    def _made(self, now_s: float) -> int:
        """Return how many steps the busiest motor has made."""
        if self._deltas is None or now_s < self._first_s:
            return 0
        count = math.floor((now_s - self._first_s) / self._interval_s + _ROUNDING) + 1
        return min(count, max(map(abs, self._deltas)))
