"""How the firmwares of the GRBL family differ in what their driver has to know: a row for each.

"Measured" and "observed" mean on the firmware itself: GRBL and grbl-Mega-5X in a processor
simulator, grblHAL and FluidNC as programs (docs/background/testing.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from firmware_protocol.grbl import Variant, keys

# The slowest step rate of an 8-bit board: its step timer counts 16 bits at 16 MHz, over at most
# eight interrupts a step. 40 steps at 5, 10, 20 and 30 steps/s took 1.278 s each. The driver uses
# no slower rate on any board, because segments would last longer.
SLOWEST_HZ = 16e6 / (8 * 65535)
# Planner size of an ATmega328P. FluidNC's has 16, the Mega's 35 and grblHAL's 100: boards with a
# larger planner also have more segments.
BLOCKS_328P = 15


@dataclass(frozen=True, slots=True)
class Paths:
    """The paths by which a firmware with a configuration file changes its settings.

    `numbered` settings have no path, `single` ones are not of an axis, and `of_axis` are the last
    words of the others' paths. No other setting can be changed. `homing` are the last words of an
    axis's paths to what GRBL says in $25, $24, $27 and $26, and to how far homing seeks, in
    travels, and approaches, in pull-offs.
    """

    numbered: tuple[int, ...]
    single: Mapping[int, str]
    of_axis: Mapping[int, str]
    homing: tuple[str, ...]

    def key(self, number: int, board: str) -> int | str | None:
        """Return the number or path that changes a setting; None if only the file does.

        `board` are the letters of the board's axes, in the order of its settings.
        """
        if number in self.numbered:
            return number
        if number in self.single:
            return self.single[number]
        group = number - number % 10
        if group in self.of_axis:
            return f"/axes/{board[number % 10].lower()}/{self.of_axis[group]}"
        return None

    def unlisted(self, homing: str) -> list[str]:
        """Return the paths that the board's list of settings leaves out, if these axes home."""
        return [*self.single.values(), *(path for each in homing for path in self.homing_of(each))]

    def homing_of(self, letter: str) -> list[str]:
        """Return the paths to what an axis homes by, in the order of `homing`."""
        return [f"/axes/{letter.lower()}/{word}" for word in self.homing]


@dataclass(frozen=True, slots=True)
class Behaviour:
    """What a firmware does; the defaults are GRBL's."""

    segments: int = 9
    """Segments that it computes ahead. The ring buffer of an ATmega2560 has ten places, one of
    which stays free, and so has grblHAL's (`SEGMENT_BUFFER_SIZE`). FluidNC's has twelve
    (`stepping/segments`): measured, it continues for 0.45 s at 39 steps/s and for 0.33 s at 50.
    """
    small_segments: int | None = None
    """As above, on a processor whose planner has no more than `BLOCKS_328P`."""
    slowest_hz: float = SLOWEST_HZ
    """Its motors turn no slower. Measured on FluidNC, whose timer counts 16 bits at 20 MHz on an
    ESP32: 40 steps at 5, 10, 20 and 30 steps/s took 1.022 s each.
    """
    holds_jogs: bool = True
    """Whether a feed hold ends a jog. grblHAL ignores it (state_machine.c, state_set)."""
    keeps_line: bool = False
    """Whether a reset out of a hold leaves the line that was read meanwhile, and it is carried out.
    Observed on FluidNC (Protocol.cpp, activeLine): it moved the arm.
    """
    reports_homing: bool = False
    """Whether it answers `?` while it homes. Observed on FluidNC, except for the time that it waits
    at a switch (`settle_ms`, 1 s at most).
    """
    report_bits: int = 3
    """Everything in a report that $10 could leave out and the driver needs: position and buffers,
    on grblHAL also speeds, pins and overrides (`$ES`, setting 10).
    """
    homing_bits: int | None = None
    """$22 with homing, if it has more than one bit. grblHAL needs the one that permits single axes,
    such as `$HX`.
    """
    sleep_switch: bool = False
    """Whether it refuses `$SLP` while $62 is 0. Observed on grblHAL, at the factory."""
    paths: Paths | None = None
    """How its settings are changed; None if all are by their numbers."""

    def segments_of(self, blocks: int | None) -> int:
        """Return the segments that a board computes ahead, from the size of its planner."""
        if self.small_segments is not None and blocks is not None and blocks <= BLOCKS_328P:
            return self.small_segments
        return self.segments

    def key(self, number: int, board: str) -> int | str | None:
        """Return the number or path that changes a setting; None if none does: see `Paths.key`."""
        return number if self.paths is None else self.paths.key(number, board)


BEHAVIOURS: Mapping[Variant, Behaviour] = MappingProxyType(
    {
        Variant.GRBL: Behaviour(small_segments=5),
        Variant.GRBLHAL: Behaviour(
            holds_jogs=False,
            report_bits=3 | 8 | 16 | 64,
            homing_bits=3,
            sleep_switch=True,
        ),
        # observed on FluidNC 4.0.5; Configuration/*.cpp, SettingsDefinitions.cpp (make_proxies)
        Variant.FLUIDNC: Behaviour(
            segments=11,
            slowest_hz=20e6 / (8 * 65535),
            keeps_line=True,
            reports_homing=True,
            paths=Paths(
                numbered=(keys.REPORT, keys.INCHES),
                single={
                    keys.IDLE_MS: "/stepping/idle_ms",
                    keys.JUNCTION: "/junction_deviation_mm",
                    keys.HOMING_RUNS: "/axes/homing_runs",
                },
                of_axis={
                    keys.STEPS_PER_UNIT: "steps_per_mm",
                    keys.RATE: "max_rate_mm_per_min",
                    keys.ACCELERATION: "acceleration_mm_per_sec2",
                    keys.TRAVEL: "max_travel_mm",
                },
                homing=(
                    "homing/seek_mm_per_min",
                    "homing/feed_mm_per_min",
                    "motor0/pulloff_mm",
                    "homing/settle_ms",
                    "homing/seek_scaler",
                    "homing/feed_scaler",
                ),
            ),
        ),
    }
)


def cautious(behaviour: Behaviour) -> Behaviour:
    """Return a behaviour with the dangers of all firmwares, for a board that may have any."""
    every = BEHAVIOURS.values()
    return replace(
        behaviour,
        segments=max(each.segments for each in every),
        small_segments=None,
        holds_jogs=all(each.holds_jogs for each in every),
        keeps_line=any(each.keeps_line for each in every),
    )
