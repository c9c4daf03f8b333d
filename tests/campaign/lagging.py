"""How far a joint leaves its path while one of the motors that turn it misses its targets.

A CiA 402 drive gets a target with every SYNC. If the bus loses one, the drive stands at the target
before, and the others go on until its stand-still shows: at three readings, or after `LOST_CYCLES`
periods unheard (docs/controllers/can.md). By then a joint that several motors turn together is off
its path, and may be beyond its limit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from armdrive.config.arm import ArmConfig
from armdrive.dialects.cia402.leading import LOST_CYCLES
from armdrive.dialects.cia402.settings import Cia402Settings


@dataclass(slots=True)
class Lagging:
    """How far each joint may be off its path at full speed, in rad, while targets are lost."""

    missed_s: float = 0.0
    """How much of its path one drive may miss; 0 if a drive does not depend on every target."""
    off_rad: Mapping[str, float] = field(default_factory=dict)
    _until_s: float = -math.inf

    @classmethod
    def of(cls, config: ArmConfig) -> Lagging:
        """Return what may happen to an arm."""
        settings = config.device
        if not isinstance(settings, Cia402Settings):
            return cls()
        missed_s = LOST_CYCLES * settings.period_ms / 1000.0
        return cls(missed_s, _missed_rad(config, missed_s))

    def begin(self, now_s: float, for_s: float) -> None:
        """Hear that targets may be lost for so long."""
        self._until_s = max(self._until_s, now_s + for_s + self.missed_s)

    def allowed_rad(self, joint: str, time_s: float) -> float:
        """Return how far a joint may be off its path at a time and at full speed."""
        return self.off_rad.get(joint, 0.0) if time_s <= self._until_s else 0.0


def _missed_rad(config: ArmConfig, missed_s: float) -> dict[str, float]:
    """Return how far one motor alone turns each joint that it shares, at most, in that time."""
    transmission, speeds = config.model.transmission, config.model.joint_speeds_rad_s
    fastest_hz = [
        math.fsum(abs(share) * speed for share, speed in zip(row, speeds, strict=False))
        for row in transmission.matrix
    ]
    return {
        name: missed_s * max(abs(share) * hz for share, hz in zip(row, fastest_hz, strict=True))
        for name, row in zip(transmission.joint_names, transmission.inverse, strict=False)
        if sum(map(bool, row)) > 1
    }
