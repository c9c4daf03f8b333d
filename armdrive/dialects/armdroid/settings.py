"""The settings of one Armdroid in the arm file: properties that vary or were never measured.

Sources: Armdroid/Armdroid-Arduino-Library (Armdroid.cpp, examples/SerialDriver) and, for the time
per character, Arduino's AVR core (CDC.cpp: polling a native USB port waits 10 ms).
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.dialects.speed_table import SpeedTable, speed_margin
from armdrive.errors import ArmFileError
from armdrive.text.toml import check_settings, setting, within
from firmware_protocol.armdroid import MOTORS, RPM_MAX

# Step intervals in whole milliseconds; for each there is a speed in rpm that gives exactly it.
INTERVALS_MS = (50, 40, 30, 25, 20, 16, 14, 12, 10, 9, 8, 7, 6, 5)
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
    speed_margin: float = speed_margin(1.5)
    channels: tuple[int, ...] = setting(
        (6, 5, 4, 3, 2, 1), "the board's channel of each motor, in the arm's order"
    )
    character_s: float = setting(
        0.010, "how long the board takes for one character", low=0.0, high=0.1
    )
    boot_s: float = setting(
        2.5, "how long the board ignores its port after it is opened", low=0.0, high=10.0
    )
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
