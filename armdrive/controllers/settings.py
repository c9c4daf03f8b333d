"""What a look at the settings of a device found: its firmware, and what is not as expected."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Difference:
    """A setting of the device that is not what the arm file expects, and the line that mends it.

    `must` says that nothing may move before it is mended.
    """

    setting: str
    found: str
    expected: str
    mend: str
    must: bool = True

    def __str__(self) -> str:
        return f"{self.setting} is {self.found}, expected {self.expected}: send `{self.mend}`"


@dataclass(frozen=True, slots=True)
class Settings:
    """What `ReadSettings` found; no differences where the dialect has no settings to compare."""

    differences: tuple[Difference, ...] = ()
    firmware: str = ""

    def __str__(self) -> str:
        return "; ".join(map(str, self.differences)) or "the settings are as expected"
