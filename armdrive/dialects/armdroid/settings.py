"""The settings of one Armdroid in the arm file: properties that vary or were never measured.

Sources: Armdroid/Armdroid-Arduino-Library (Armdroid.cpp, examples/SerialDriver) and, for the time
per character, Arduino's AVR core (CDC.cpp: polling a native USB port waits 10 ms).
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

from armdrive.dialects.speed_table import SpeedMeter, SpeedTable
from armdrive.errors import ArmFileError
from armdrive.text.toml import check_settings, setting, within
from firmware_protocol.armdroid import MOTORS, RPM_MAX
from kinematics.spaces import Motors

INTERVALS_MS = (50, 40, 30, 25, 20, 16, 14, 12, 10, 9, 8, 7, 6, 5)
"""Step intervals in whole milliseconds; for each there is a speed in rpm that gives exactly it."""
SKETCH_SPEEDS = tuple((RPM_MAX // ms, 1000.0 / ms) for ms in INTERVALS_MS)


@dataclass(frozen=True, slots=True)
class ArmdroidSettings:
    """How the board turns motors and reads characters; every default is the cautious one.

    Only the speeds listed in `speed_table` are used, since the board rounds the rest to whole
    milliseconds.
    """

    speed_table: tuple[tuple[int, float], ...] = setting(
        SKETCH_SPEEDS, "rpm as sent to the board, and the resulting steps a second"
    )
    speed_margin: float = setting(
        1.5,
        "how many times slower the arm may be, until it has been measured",
        low=1.0,
        high=20.0,
    )
    channels: tuple[int, ...] = setting(
        (6, 5, 4, 3, 2, 1), "the board's channel of each motor, in the arm's order"
    )
    character_s: float = setting(
        0.010, "how long the board takes for one character", low=0.0, high=0.1
    )
    boot_s: float = setting(
        2.5, "how long the board ignores its port after it is opened", low=0.0, high=10.0
    )
    check_numbers: bool = setting(True, "have the board repeat a motion's numbers before it starts")
    switches_torque: bool = setting(True, "false for firmware before 2.0, which has no t")
    answer_margin_s: float = setting(0.5, "added to every deadline", low=0.1, high=10.0)

    def __post_init__(self) -> None:
        check_settings(self, "armdroid")
        for rpm, rate_hz in SpeedTable(self.speed_table).points:
            within("armdroid.speed_table's rpm", rpm, 1, RPM_MAX)
            within("armdroid.speed_table's rate", rate_hz, 1.0, 2000.0)
        if sorted(self.channels) != list(range(1, MOTORS + 1)):
            raise ArmFileError(
                f"armdroid.channels lists each channel from 1 to {MOTORS} once, in the order of "
                f"the arm's motors, for example [6, 5, 4, 3, 2, 1], not {list(self.channels)}"
            )


# How fast an Armdroid's motors turn, and how far they leave the straight path.
#
# The board steps every motor that has steps left at the same rate. A motor with few steps finishes
# early, so the path bends. Units: steps, steps per second, seconds.

_ROUNDING = 1e-9


class StepRates:
    """The board's speed settings, and the rates measured for them."""

    def __init__(self, points: tuple[tuple[int, float], ...], doubt: float) -> None:
        self._rates = dict(points)
        self._meter = SpeedMeter(SpeedTable(points), doubt)

    @property
    def fastest_hz(self) -> float:
        """The highest available rate."""
        return max(self._rates.values())

    def number_bytes(self, burst_s: float) -> int:
        """Bound the number of characters that one motor's steps take in a burst."""
        return len(f"{max(int(burst_s * self.fastest_hz), 1)}-,")

    def rpm(self, rate_hz: float) -> int:
        """Return the highest speed at or below a rate, or else the lowest speed."""
        found = bisect_right(list(self._rates.values()), rate_hz + _ROUNDING)
        return list(self._rates)[max(found - 1, 0)]

    def rate_hz(self, rpm: int) -> float:
        """Return a speed's rate in steps per second."""
        return self._rates[rpm]

    def longest_s(self, steps: float, rpm: int) -> float:
        """Return the longest time that the steps may take."""
        return steps / self._rates[rpm] * self._meter.part(rpm).doubt

    def measured(self, steps: int, rpm: int, *, least_s: float, most_s: float) -> bool:
        """Learn from a motion's duration; return False if it is not plausible.

        The motors make their first step at once, so n steps take n - 1 intervals.
        """
        whole_s = steps / self._rates[rpm]
        meter = self._meter.part(rpm)
        believable = any(meter.believable(whole_s, took_s) for took_s in (least_s, most_s))
        meter.learn((steps - 1) / self._rates[rpm], least_s)
        return believable


def deviation_steps(steps: Motors) -> tuple[float, ...]:
    """Bound each motor's lead over its share of the path, in steps."""
    most = max(steps.largest, 1)
    return tuple(abs(each) * (1.0 - abs(each) / most) for each in steps)
