"""The segment buffer of a GRBL board: motion that it has computed and no longer changes.

The stepper driver of the firmware computes segments of 10 ms ahead of the motors. A segment holds
at least 1.25 steps of the busiest motor, so that a slow one lasts longer. Nothing that arrives
later changes these segments: a feed hold begins to brake after them, the planner reads empty while
they are still to be driven, and a queue that ends within them starves.

Sources: gnea/grbl grbl/stepper.c (st_prep_buffer), stepper.h; grblHAL/core stepper.h; FluidNC
`stepping/segments`. Seen: the Mega goes on for 0.43 s at 31 steps/s, a 328p for 0.24 s.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.controllers.controller import Part
from armdrive.controllers.grbl_plan import Way
from firmware_protocol.grbl import Variant

SEGMENT_S = 0.01
STEPS_A_SEGMENT = 1.25
SLOWEST_HZ = 16e6 / (8 * 65535)
"""An 8-bit board turns a motor no slower: its step timer counts 16 bits at 16 MHz, over at most
eight interrupts a step. 40 steps at 5, 10, 20 and 30 steps/s took 1.278 s each. The driver asks
for no slower rate of any board, as segments would last longer then."""
LAST_STEP_S = 1.0 / SLOWEST_HZ
"""The step that a motor has begun is made, however slowly it comes."""
SHORTEST_HZ = STEPS_A_SEGMENT / SEGMENT_S
"""At this rate and above it, a segment lasts no longer than 10 ms."""
FEW_BLOCKS = 15
"""The planner of an ATmega328P. Boards with a larger one have more segments, too."""
SEGMENTS: Mapping[Variant, int] = MappingProxyType(
    {Variant.GRBL: 9, Variant.GRBLHAL: 10, Variant.FLUIDNC: 12}
)
"""How many segments a firmware computes ahead: the ring of an ATmega2560 has ten places, one of
which stays free. Those of grblHAL and FluidNC are their sources' defaults."""
SEGMENTS_328P = 5


def segments_of(variant: Variant, blocks: int | None) -> int:
    """Return how many segments a board computes ahead, by its firmware and its planner's size."""
    small = variant is Variant.GRBL and blocks is not None and blocks <= FEW_BLOCKS
    return SEGMENTS_328P if small else SEGMENTS[variant]


@dataclass(frozen=True, slots=True)
class SegmentBuffer:
    """The buffer of one board, which computes `segments` ahead."""

    segments: int

    @property
    def longest_s(self) -> float:
        """How much motion it holds at most: at the slowest rate."""
        return self.segments * self._segment_s(SLOWEST_HZ)

    def longest_of_s(self, parts: Sequence[Part], piece_s: float) -> float:
        """Return how much of a motion it holds at most, wherever in it.

        The motion is sent in pieces of `piece_s` or longer, or part by part where those are
        shorter; in whole steps, so that a piece may be one step short of its rate. As the window
        slides along, what it holds changes evenly until one of its ends comes to where two parts
        meet: the longest begins or ends there.
        """
        counted = [
            (
                part.duration_s,
                self._segment_s(part.rate_hz - 1.0 / max(min(part.duration_s, piece_s), 1e-6)),
            )
            for part in parts
        ]
        ways = (counted, counted[::-1])
        return max(self._filled_s(way, start) for way in ways for start in range(len(way)))

    @staticmethod
    def slow_ramp_s(rate_hz: float, slope: float) -> float:
        """Return by how much the board's own ramp to a rate makes segments longer, at most.

        Below `SHORTEST_HZ` they are longer than 10 ms, and a ramp is below it for so long.
        """
        return min(rate_hz, SHORTEST_HZ) / slope

    def _filled_s(self, counted: Sequence[tuple[float, float]], start: int) -> float:
        """Return how long the segments of as many parts last as it has room for, from one on."""
        left, total_s = float(self.segments), 0.0
        for index in range(start, len(counted)):
            duration_s, segment_s = counted[index]
            count = min(duration_s / segment_s, left)
            left, total_s = left - count, total_s + count * segment_s
            if left <= 0.0:
                break
        return total_s

    def most_steps(self, fastest_hz: float) -> float:
        """Return how many steps of a motor it holds at most, which turns no faster than this.

        A segment lasts 10 ms, or as many times 10 ms as it takes for 1.25 steps: less than 2.5.
        """
        return self.segments * max(fastest_hz * SEGMENT_S, 2.0 * STEPS_A_SEGMENT)

    def holds_s(self, ways: Iterable[Way]) -> float:
        """Return how much of the motion along lines it holds, from where the first one begins."""
        left, total_s, segment_s = float(self.segments), 0.0, 0.0
        for each in ways:
            segment_s = self._segment_s(each.rate_hz)
            count = each.nominal_s / segment_s
            if count >= left:
                break
            left -= count
            total_s += each.nominal_s
        return total_s + left * segment_s

    @staticmethod
    def _segment_s(rate_hz: float) -> float:
        least_s = STEPS_A_SEGMENT / max(rate_hz, SLOWEST_HZ)
        return SEGMENT_S * math.ceil(least_s / SEGMENT_S - 1e-9)
