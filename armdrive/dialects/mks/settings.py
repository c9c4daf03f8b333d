"""The arm file's section `[mks]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import re
from dataclasses import dataclass

from armdrive.dialects.bus.drives import check_feeding, check_ids
from armdrive.errors import ArmFileError
from armdrive.text.toml import check_settings, setting, within
from firmware_protocol.mks import CURRENT_MAX_MA, NODE_MAX

# Only with these are the drive's speeds in rpm.
MICROSTEPS = (16, 32, 64)
_FIRMWARE = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{1,2})")


@dataclass(frozen=True, slots=True)
class MksSettings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    Drives with firmware before 1.0.8 do not report their version. With `segment_s` of 0 a motion is
    sent in bursts.
    """

    ids: tuple[int, ...] = setting(
        (1, 2, 3, 4, 5, 6), "CAN ids, in the order of the motors", low=1, high=NODE_MAX
    )
    firmware: str = setting("", "the oldest firmware, such as 1.0.9; empty asks the drives")
    watchdog_s: float = setting(
        0.5, "drives stop when the bus is silent this long; 0 changes nothing", low=0.0, high=60.0
    )
    acceleration: int = setting(
        252, "the drive's measure of a ramp, 1 to 255; 0 for none", low=0, high=255
    )
    current_ma: int = setting(
        0, "compared with the drives'; 0 does not compare", low=0, high=CURRENT_MAX_MA
    )
    microsteps: int = setting(16, "compared with the drives': 16, 32 or 64")
    poll_s: float = setting(0.1, "how often moving drives are polled", low=0.02, high=1.0)
    answer_s: float = setting(0.05, "timeout of an answer", low=0.01, high=2.0)
    segment_s: float = setting(
        0.04, "how often a motion is steered, from 0.01; 0 sends bursts", low=0.0, high=0.1
    )
    in_position_counts: int = setting(
        8, "a drive that holds is this close to its target", low=1, high=1000
    )
    following_error_counts: int = setting(
        1600, "following error allowed beyond the distance of 0.1 s", low=50, high=100_000
    )
    homing_s: float = setting(
        60.0, "longest homing of a drive that does not report its speed", low=1.0, high=3600.0
    )

    def __post_init__(self) -> None:
        check_settings(self, "mks")
        check_ids("mks", self.ids, "an id")
        if self.firmware and _FIRMWARE.fullmatch(self.firmware) is None:
            raise ArmFileError(f'mks.firmware must look like "1.0.9", not {self.firmware!r}')
        if self.microsteps not in MICROSTEPS:
            known = ", ".join(map(str, MICROSTEPS))
            raise ArmFileError(
                f"mks.microsteps must be one of {known}, not {self.microsteps}: only with these "
                "are the drive's speeds in rpm"
            )
        if self.watchdog_s:
            check_feeding("mks.watchdog_s", self.watchdog_s, "mks.poll_s", self.poll_s)
        if self.segment_s:
            within("mks.segment_s", self.segment_s, 0.01, 0.1)

    @property
    def version(self) -> tuple[int, int, int] | None:
        """The firmware as numbers; None if the drives are asked."""
        found = _FIRMWARE.fullmatch(self.firmware)
        if found is None:
            return None
        first, second, third = (int(part) for part in found.groups())
        return first, second, third
