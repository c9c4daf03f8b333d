"""The ways in which arms on drives on a CAN bus are moved, each by the lines of an arm file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class Strategy:
    """One way to move an arm: the dialect's drives, and what their section of an arm file says."""

    dialect: str
    lines: str = ""

    def section(self, more: str = "") -> str:
        """Return the section of an arm file that moves by it."""
        return f"[{self.dialect}]\n{self.lines}{more}"


STRATEGIES: Mapping[str, Strategy] = MappingProxyType(
    {
        "steered": Strategy("mks"),
        "together": Strategy("mks", "segment_s = 0.0\n"),
        "in turn": Strategy("mks", 'segment_s = 0.0\nfirmware = "1.0.4"\n'),
        "cyclic": Strategy("cia402"),
        "profile": Strategy("cia402", 'strategy = "profile"\n'),
    }
)
"""Of MKS drives: targets in flight (`F5`), which is the usual one; bursts with scaled speeds and a
synchronous start (`4A`, `4B`); the same, each drive started by a frame of its own. Of CiA 402
drives: a target with every SYNC, which is the usual one; bursts by profile position."""

RATES: Mapping[str, Strategy] = MappingProxyType(
    {
        "25 Hz": Strategy("mks", "segment_s = 0.04\n"),
        "50 Hz": Strategy("mks", "segment_s = 0.02\n"),
        "100 Hz": Strategy("mks", "segment_s = 0.01\n"),
        "CSP 50 Hz": Strategy("cia402", "period_ms = 20\n"),
        "CSP 100 Hz": Strategy("cia402", "period_ms = 10\n"),
    }
)
"""How often targets are given; MKS drives have 25 Hz usually, CiA 402 drives 100 Hz."""


def groups(strategies: Mapping[str, Strategy]) -> dict[str, tuple[str, ...]]:
    """Return the names of the strategies of each dialect."""
    found: dict[str, tuple[str, ...]] = {}
    for name, strategy in strategies.items():
        found[strategy.dialect] = (*found.get(strategy.dialect, ()), name)
    return found


_COUNTS = MappingProxyType({"mks": 0x4000, "cia402": 10_000})
"""Of a motor's turn, in the templates of arms on these drives."""
_GEARS = MappingProxyType(
    {"base": 50, "shoulder": 50, "elbow": 40, "right wrist": 20, "left wrist": 20}
)


def measured(dialect: str) -> str:
    """Return the lines of an arm whose owner has measured it, so that it knows Cartesian goals.

    Its twin is made by the same file.
    """
    counts = _COUNTS[dialect]
    gears = "".join(f'"{joint}" = {turns * counts}\n' for joint, turns in _GEARS.items())
    return f"{_LENGTHS}\n[steps_per_turn]\n{gears}\n"


_LENGTHS = """
[lengths]
base_height_mm = 195.4
upper_arm_mm = 177.6
forearm_mm = 178.1
hand_mm = 96.9
"""
