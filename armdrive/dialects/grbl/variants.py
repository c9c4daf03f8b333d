"""How the firmwares of the GRBL family differ in what their driver has to know: a row for each.

"Measured" and "observed" mean on the firmware itself: GRBL and grbl-Mega-5X in a processor
simulator, grblHAL and FluidNC as programs (docs/background/testing.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from firmware_protocol.grbl import Variant, keys

# The slowest step rate of an 8-bit board: its step timer counts 16 bits at 16 MHz, over at most
# eight interrupts a step. 40 steps at 5, 10, 20 and 30 steps/s took 1.278 s each. The driver uses
# no slower rate on any board, because segments would last longer.
SLOWEST_HZ = 16e6 / (8 * 65535)
# How far homing seeks a switch, in travels ($130), and how far it approaches it, in pull-offs.
SEARCH_TRAVELS, LOCATE_PULL_OFFS = 1.5, 10.0


@dataclass(frozen=True, slots=True)
class Behaviour:
    """What a firmware does; the defaults are GRBL's."""

    segments: int = 9
    """Segments that it computes ahead. The ring buffer of an ATmega2560 has ten places, one of
    which stays free, and so has grblHAL's (`SEGMENT_BUFFER_SIZE`). FluidNC's has twelve
    (`stepping/segments`): measured, it continues for 0.45 s at 39 steps/s and for 0.33 s at 50. An
    ATmega328P has six, but no outputs for the motors of an arm.
    """
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
    paths: Mapping[int, int | str] = field(default_factory=dict)
    """What changes a setting: its number, or a path in the configuration file, where `{}` is an
    axis. A setting that is missing here can be changed in the file only. Empty: all have numbers.
    """
    homing: tuple[int | str, ...] = (
        keys.HOMING_SEEK, keys.HOMING_FEED, keys.PULL_OFF, keys.DEBOUNCE_MS,
    )  # fmt: skip
    """The settings by which an axis homes: its speeds of seeking and approaching, the way back, the
    pause at a switch, and on FluidNC the distances sought and approached, in travels and pull-offs.
    """
    pulls_off_slowly: bool = False
    """Whether homing backs off a switch as slowly as it approaches it. Observed on FluidNC."""

    def key(self, number: int, board: str) -> int | str | None:
        """Return the number or path that changes a setting; None if only the file does.

        `board` are the letters of the board's axes, in the order of its settings.
        """
        if not self.paths:
            return number
        if number < keys.STEPS_PER_UNIT:
            return self.paths.get(number)
        path = self.paths.get(number - number % 10)
        return None if path is None else str(path).format(board[number % 10].lower())

    def homing_of(self, letter: str) -> list[int | str]:
        """Return the settings by which an axis homes, in the order of `homing`."""
        return [key.format(letter.lower()) if isinstance(key, str) else key for key in self.homing]

    def unlisted(self, homing: str) -> list[str]:
        """Return the paths that the board's `$$` leaves out, if these axes home."""
        paths = [path for number, path in self.paths.items() if number < keys.STEPS_PER_UNIT]
        wanted = (*paths, *(path for letter in homing for path in self.homing_of(letter)))
        return [path for path in wanted if isinstance(path, str)]


BEHAVIOURS: Mapping[Variant, Behaviour] = MappingProxyType(
    {
        Variant.GRBL: Behaviour(),
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
            paths={
                keys.REPORT: keys.REPORT,
                keys.INCHES: keys.INCHES,
                keys.IDLE_MS: "/stepping/idle_ms",
                keys.JUNCTION: "/junction_deviation_mm",
                keys.HOMING_RUNS: "/axes/homing_runs",
                keys.STEPS_PER_UNIT: "/axes/{}/steps_per_mm",
                keys.RATE: "/axes/{}/max_rate_mm_per_min",
                keys.ACCELERATION: "/axes/{}/acceleration_mm_per_sec2",
                keys.TRAVEL: "/axes/{}/max_travel_mm",
            },
            homing=(
                "/axes/{}/homing/seek_mm_per_min",
                "/axes/{}/homing/feed_mm_per_min",
                "/axes/{}/motor0/pulloff_mm",
                "/axes/{}/homing/settle_ms",
                "/axes/{}/homing/seek_scaler",
                "/axes/{}/homing/feed_scaler",
            ),
            pulls_off_slowly=True,
        ),
    }
)


def cautious(behaviour: Behaviour) -> Behaviour:
    """Return a behaviour with the dangers of all firmwares, for a board that may have any."""
    most = max(each.segments for each in BEHAVIOURS.values())
    return replace(behaviour, segments=most, holds_jogs=False, keeps_line=True)
