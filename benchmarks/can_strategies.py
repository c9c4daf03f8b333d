"""The ways in which an arm on MKS drives is moved, each by the lines of an arm file for it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

DIALECT = "mks"

STRATEGIES: Mapping[str, str] = MappingProxyType(
    {
        "steered": "",
        "together": "segment_s = 0.0\n",
        "in turn": 'segment_s = 0.0\nfirmware = "1.0.4"\n',
    }
)
"""Targets in flight (`F5`), which is the usual one; bursts with scaled speeds and a synchronous
start (`4A`, `4B`); the same, each drive started by a frame of its own."""


def section(strategy: str, more: str = "") -> str:
    """Return the `[mks]` section of an arm file that moves by a strategy."""
    return f"[{DIALECT}]\n{STRATEGIES[strategy]}{more}"


MEASURED = """
[lengths]
base_height_mm = 195.4
upper_arm_mm = 177.6
forearm_mm = 178.1
hand_mm = 96.9

[steps_per_turn]
base = 819200
shoulder = 819200
elbow = 655360
"right wrist" = 327680
"left wrist" = 327680
"""
"""An arm whose owner has measured it, so that it knows Cartesian goals. Its twin is made by the
same file."""
