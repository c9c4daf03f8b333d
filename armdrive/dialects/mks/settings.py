"""The arm file's section `[mks]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.dialects.bus.drives import check_feeding, check_settings
from armdrive.errors import ArmFileError
from armdrive.text.toml import within
from firmware_protocol.mks import CURRENT_MAX_MA, NODE_MAX

MICROSTEPS = (16, 32, 64)
"""Only with these are the drive's speeds in rpm."""
_FIRMWARE = re.compile(r"(\d{1,3})\.(\d{1,3})\.(\d{1,3})")


@dataclass(frozen=True, slots=True)
class MksSettings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    `ids` are their CAN ids. If `firmware` is empty, the drives are asked for it; firmware before
    1.0.8 does not report its version. `watchdog_s` is how long the bus may be silent before the
    drives stop by themselves (0: not changed). `acceleration` is the drive's measure of a ramp, 1
    to 255, 0 for none. `current_ma` and `microsteps` are compared with those of the drives (current
    0: not compared).

    Moving drives are polled every `poll_s`, and `answer_s` is the timeout of an answer. A motion is
    steered every `segment_s`; with 0 it is sent in bursts, which start together if the firmware has
    a synchronous start. A drive that holds its target is within `rest_counts` of it. In motion it
    may be `corridor_counts` behind, beyond the distance of 0.1 s. Homing may take `homing_s`.
    """

    ids: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    firmware: str = ""
    watchdog_s: float = 0.5
    acceleration: int = 252
    current_ma: int = 0
    microsteps: int = 16
    poll_s: float = 0.1
    answer_s: float = 0.05
    segment_s: float = 0.04
    rest_counts: int = 8
    corridor_counts: int = 1600
    homing_s: float = 60.0

    def __post_init__(self) -> None:
        check_settings("mks", self, NODE_MAX, "an id", _BOUNDS)
        if self.firmware and _FIRMWARE.fullmatch(self.firmware) is None:
            raise ArmFileError(f'mks.firmware is written "1.0.9", not {self.firmware!r}')
        if self.microsteps not in MICROSTEPS:
            known = ", ".join(map(str, MICROSTEPS))
            raise ArmFileError(
                f"mks.microsteps must be one of {known}, not {self.microsteps}: only with these "
                "are the drive's speeds in rpm"
            )
        if self.watchdog_s:
            check_feeding(self, "mks.watchdog_s", "mks.poll_s")
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


_BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "watchdog_s": (0.0, 60.0),
        "acceleration": (0, 255),
        "current_ma": (0, CURRENT_MAX_MA),
        "poll_s": (0.02, 1.0),
        "answer_s": (0.01, 2.0),
        "segment_s": (0.0, 0.1),
        "rest_counts": (1, 1000),
        "corridor_counts": (50, 100_000),
        "homing_s": (1.0, 290.0),
    }
)
