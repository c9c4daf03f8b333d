"""The arm file's section `[teachmover]`: facts that were never published or differ between arms."""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.dialects.speed_table import SpeedTable, speed_margin
from armdrive.text.toml import check_settings, setting, within
from firmware_protocol.teachmover import SPEED_MAX


@dataclass(frozen=True, slots=True)
class TeachMoverSettings:
    """The arm file's settings for facts that were never published or differ between arms."""

    speed_table: tuple[tuple[int, float], ...] = setting(
        (
            (0, 30.0),
            (140, 150.0),
            (190, 250.0),
            (240, 470.0),
        ),
        "SP, half-steps a second",
    )
    speed_margin: float = speed_margin(2.0)
    grip_bit: int = setting(0, "input bit of the grip switch", low=0, high=7)
    answer_margin_s: float = setting(0.5, "added to every deadline", low=0.1, high=10.0)

    def __post_init__(self) -> None:
        check_settings(self, "teachmover")
        for speed, rate_hz in SpeedTable(self.speed_table).points:
            within("teachmover.speed_table's setting", speed, 0, SPEED_MAX)
            within("teachmover.speed_table's rate", rate_hz, 1.0, 20_000.0)
