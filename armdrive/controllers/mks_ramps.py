"""The ramps of MKS drives, in counts a second squared, and shared so that all keep in step."""

from __future__ import annotations

from firmware_protocol.mks import COUNTS_PER_TURN, acc_of, ramp_rpm_s

COUNTS_S_PER_RPM = COUNTS_PER_TURN / 60.0
"""Counts a second of one rpm."""
LEAST_SHARE = 0.1
"""A slow drive's ramp is at least this share of the steepest: it has corners to follow."""


def slope_of(acc: int) -> float:
    """Return a ramp in counts a second squared; infinity for 0, which has none."""
    return ramp_rpm_s(acc) * COUNTS_S_PER_RPM


def shared_acc(acc: int, share: float) -> int:
    """Return the ramp of a drive that goes at a share of the fastest one's speed.

    So all come to their speeds, and to rest, in the same time, and stay in proportion.
    """
    return acc_of(max(share, LEAST_SHARE) * ramp_rpm_s(acc)) if acc else 0


def whole_rpm(rpm: int, most: int) -> int:
    """Return a speed that a drive can be told: at least 1, and no more than so much."""
    return min(max(rpm, 1), most)
