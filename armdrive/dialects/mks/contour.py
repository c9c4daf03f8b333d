"""Compare where all drives are with their common path: one that lags alone leads the arm off it.

The observer judges each drive by its own orders. That is not enough: each may be within its
corridor, one early and another late, and the arm between two points of its path in no place that
was planned. And a weak drive that is steered from where it was read is never far from its orders.
So here all positions of one look are compared with the path: is there a moment at which all would
be where they are?
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.dialects.bus.intervals import CONFIRMING_LOOKS, DriveFinding
from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.observer import Verdict
from armdrive.dialects.mks.paths import KEPT_S, SteeredPath

APART_SHARE = 0.2
"""Drives are apart if no single time offset explains all positions within this share of what still
counts as on the path. On a link whose delays are equal, or vary by up to 0.04 s, they never are."""


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
        drive = self._drives[worst]
        return Verdict(drive, DriveFinding.OFF_PATH, drive.count, path.at(worst, late_s))
