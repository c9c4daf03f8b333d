"""Compare where all drives are with their common path: one that lags alone leads the arm off it.

The observer judges each drive by its own orders. That is not enough: each may be within its
corridor, one early and another late, and the arm between two points of its path in no place that
was planned. And a weak drive that is steered from where it was read is never far from its orders.
So here all positions of one look are compared: with each other (is one always slower?), and with
the path (is there a moment at which all would be where they are?).
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.dialects.bus.intervals import CONFIRMING_LOOKS, DriveFinding
from armdrive.dialects.mks.drive import WEAK_LOOKS, MksDrive
from armdrive.dialects.mks.observer import Verdict
from armdrive.dialects.mks.paths import KEPT_S, SteeredPath

APART_SHARE = 0.2
"""Drives are apart if no single time offset explains all positions within this share of what still
counts as on the path. On a link whose delays are equal, or vary by up to 0.04 s, they never are."""
WEAK_SHARE = 0.75
"""A drive that turns less than this share of what another one turns is too slow."""


class ContourCheck:
    """The drives of one motion on their common path."""

    def __init__(self, drives: Sequence[MksDrive], path: SteeredPath) -> None:
        self._drives, self._path = drives, path
        self.apart = False
        """Whether a drive was behind the others at the last look."""
        self._looks_off_path = 0

    def compare(self, asked_at_s: float, period_s: float, now_s: float) -> Verdict | None:
        """Compare the positions of all drives at one look with their path.

        `asked_at_s` is the path time of that look. Drives that all lag by the same time are on
        the path, only later.
        """
        path, counts = self._path, [drive.count for drive in self._drives]
        slow = self._weak()
        if slow is not None:
            off = abs(path.at(slow, asked_at_s) - counts[slow])
            if off > self._drives[slow].bounds.corridor / 2.0:
                return self._verdict(slow, path.at(slow, asked_at_s), DriveFinding.WEAK)
        margins = [drive.margin(now_s) for drive in self._drives]
        late_s = min(asked_at_s + period_s, path.end_s)
        early_s, near = max(late_s - KEPT_S, 0.0), [APART_SHARE * each for each in margins]
        self.apart = not path.explains(counts, near, early_s, late_s)
        if not self.apart or path.explains(counts, margins, early_s, late_s):
            self._looks_off_path = 0
            return None
        self._looks_off_path += 1
        if self._looks_off_path < CONFIRMING_LOOKS:
            return None
        worst = max(
            range(len(counts)),
            key=lambda motor: abs(path.at(motor, late_s) - counts[motor]) / margins[motor],
        )
        return self._verdict(worst, path.at(worst, late_s), DriveFinding.OFF_PATH)

    def _verdict(self, motor: int, place: float, finding: DriveFinding) -> Verdict:
        drive = self._drives[motor]
        return Verdict(drive, finding, drive.count, place)

    def _weak(self) -> int | None:
        """Return the index of a drive that turns less than another one at every look.

        A drive that moves alone cannot lag others: it is on its path, only late.
        """
        found = {i: shares for i, each in enumerate(self._drives) if (shares := each.shares.each)}
        if len(found) < 2:
            return None
        slowest = min(found, key=lambda motor: max(found[motor]))
        # a share above 1 only makes up for an earlier delay
        best = min(max(sum(shares) / WEAK_LOOKS for shares in found.values()), 1.0)
        return slowest if max(found[slowest]) < WEAK_SHARE * best else None
