"""What an arm file says in `[mks]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.dialects.bus.motors import check_ids
from armdrive.errors import ArmFileError
from armdrive.text.toml import within
from firmware_protocol.mks import CURRENT_MAX_MA, NODE_MAX

MICROSTEPS = (16, 32, 64)
"""With these alone the drive's speeds are rpm."""
FEEDS = 2
"""So many looks the drives' watchdog must outlast: one may be lost."""
_FIRMWARE = re.compile(r"(\d{1,3})\.(\d{1,3})\.(\d{1,3})")


@dataclass(frozen=True, slots=True)
class MksSettings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    `ids` are their CAN ids. `firmware` is asked of the drives where it is left empty; firmware
    before 1.0.8 cannot tell it. `watchdog_s` is the drives' own: they stop when the bus has been
    silent for so long (0: left as it is). `acceleration` is the drive's measure of a ramp, 1 to
    255, 0 for none. `current_ma` and `microsteps` are compared with the drives' (current 0: as
    it is).

    Times: a drive is looked at every `poll_s` while it moves, and an answer is waited for
    `answer_s`. A motion is steered every `segment_s`; 0 sends it in bursts instead, which start
    together where the firmware has the synchronous start. `rest_counts` is how far from its
    target a drive stands that holds it, and `corridor_counts` how far it may be behind in motion,
    beyond what it runs in 0.1 s. Homing may take `homing_s`.
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
        check_ids("mks", self.ids, NODE_MAX, "an id")
        if self.firmware and _FIRMWARE.fullmatch(self.firmware) is None:
            raise ArmFileError(f'mks.firmware is written "1.0.9", not {self.firmware!r}')
        if self.microsteps not in MICROSTEPS:
            known = ", ".join(map(str, MICROSTEPS))
            raise ArmFileError(
                f"mks.microsteps is one of {known}, since the drive's speeds are rpm with these "
                f"alone, not {self.microsteps}"
            )
        for name, (low, high) in _BOUNDS.items():
            within(f"mks.{name}", getattr(self, name), low, high)
        if 0.0 < self.watchdog_s < FEEDS * self.poll_s - 1e-9:
            raise ArmFileError(
                f"mks.watchdog_s must be 0, or {FEEDS} times mks.poll_s at least, which feeds it: "
                f"with {self.watchdog_s:g} and {self.poll_s:g} the drives would stop in mid-motion"
            )
        if self.segment_s:  # 0 is none
            within("mks.segment_s", self.segment_s, 0.01, 0.1)

    @property
    def version(self) -> tuple[int, int, int] | None:
        """The firmware as numbers; None where the drives are asked."""
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
