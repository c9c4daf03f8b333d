"""What an arm file says in `[mks]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import re
from dataclasses import dataclass

from armdrive.dialects.bus.motors import check_ids
from armdrive.errors import ArmFileError
from armdrive.text.toml import check_settings, setting, within
from firmware_protocol.mks import CURRENT_MAX_MA, NODE_MAX

MICROSTEPS = (16, 32, 64)
"""With these alone the drive's speeds are rpm."""
FEEDS = 2
"""The drives' watchdog must outlast this many reads, since one may be lost."""
_FIRMWARE = re.compile(r"(\d{1,3})\.(\d{1,3})\.(\d{1,3})")


@dataclass(frozen=True, slots=True)
class MksSettings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    A position is streamed every `segment_s`. With 0, motions are sent in bursts, which start
    together if the firmware has the synchronous start.
    """

    ids: tuple[int, ...] = setting(
        (1, 2, 3, 4, 5, 6), "the CAN id of each motor's drive", low=1, high=NODE_MAX
    )
    firmware: str = setting("", "1.0.9 say; empty asks the drives, which 1.0.8 and later answer")
    watchdog_s: float = setting(
        0.5,
        "a drive stops when the bus is silent for this long; 0 leaves it as set",
        low=0.0,
        high=60.0,
    )
    acceleration: int = setting(
        252, "the drive's own measure of a ramp; 0 for none", low=0, high=255
    )
    current_ma: int = setting(
        0,
        "compared with the drives' motor current; 0 leaves it as set",
        low=0,
        high=CURRENT_MAX_MA,
    )
    microsteps: int = setting(16, "compared with the drives': 16, 32 or 64")
    poll_s: float = setting(0.1, "how often a moving drive is read", low=0.02, high=1.0)
    answer_s: float = setting(
        0.05, "how long an answer may take before it is asked for again", low=0.01, high=2.0
    )
    segment_s: float = setting(
        0.04, "how often a position is streamed; 0 sends bursts instead", low=0.0, high=0.1
    )
    rest_counts: int = setting(
        8, "a standing drive is at most this far from its target", low=1, high=1000
    )
    corridor_counts: int = setting(
        1600,
        "how far a moving drive may lag, beyond what it turns in 0.1 s",
        low=50,
        high=100_000,
    )
    homing_s: float = setting(60.0, "homing takes at most this long", low=1.0, high=290.0)

    def __post_init__(self) -> None:
        check_settings(self, "mks")
        check_ids("mks", self.ids, "an id")
        if self.firmware and _FIRMWARE.fullmatch(self.firmware) is None:
            raise ArmFileError(f'mks.firmware is written "1.0.9", not {self.firmware!r}')
        if self.microsteps not in MICROSTEPS:
            known = ", ".join(map(str, MICROSTEPS))
            raise ArmFileError(
                f"mks.microsteps is one of {known}, since the drive's speeds are rpm with these "
                f"alone, not {self.microsteps}"
            )
        if 0.0 < self.watchdog_s < FEEDS * self.poll_s - 1e-9:
            raise ArmFileError(
                f"mks.watchdog_s must be 0, or {FEEDS} times mks.poll_s at least, which feeds it: "
                f"with {self.watchdog_s:g} and {self.poll_s:g} the drives would stop in mid-motion"
            )
        if self.segment_s:  # 0 means bursts
            within("mks.segment_s", self.segment_s, 0.01, 0.1)

    @property
    def version(self) -> tuple[int, int, int] | None:
        """The firmware as numbers; None where the drives are asked."""
        found = _FIRMWARE.fullmatch(self.firmware)
        if found is None:
            return None
        first, second, third = (int(part) for part in found.groups())
        return first, second, third
