"""Whether an MKS drive that is seen off its way cannot go on, or was only late and is coming.

Orders come late on a busy computer, or to a bus that stands still for a moment: then a drive that
is well is as far behind as one that is blocked. It is given time, and looked at again; only who
has neither come nearer by then nor kept pace is blamed.

Who keeps pace may be far behind its model without danger, since two others look at what that would
hide: whether all are on the way that was checked, only later (mks_beside), and whether a count has
leapt, as that of a drive does which begins anew (mks_leap). Before those, such a drive was tried in
simulations to go 54,000 counts beyond its target, and one at 60 % of its speed to be 65,000 beside
its way, and neither was told. A smaller `FOLLOWED` would blame drives whose orders are late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

AGAIN_S = 0.05
"""A second look was asked for at least so long after the first one was heard."""
PACE = 0.5
"""A drive keeps pace that turns by this share of what it should, at least."""
FOLLOWED = 3.0
"""One that keeps pace is waited for if it is off by no more than so many times what is let pass."""


@dataclass(slots=True)
class Doubt:
    """The look at which one drive was off its way, since it was seen on it. Counts, seconds."""

    heard_s: float = math.inf
    """When that was heard; infinity where nothing is doubted."""
    _count: int = 0
    _apart: float = 0.0

    def forget(self) -> None:
        """Doubt it no more."""
        self.heard_s = math.inf

    def is_too_soon(self, asked_s: float) -> bool:
        """Tell whether a look that was asked for then proves nothing beside the first one.

        A first look that was read late, after a wake, say, is followed by one asked for since.
        """
        return math.isfinite(self.heard_s) and asked_s < self.heard_s + AGAIN_S

    def is_well(self, count: int, place: float, let_pass: float, least: int) -> bool:
        """Tell whether it goes on as it should since the look before, or there was none.

        It has come nearer to where it should be, by its own turning; or it keeps pace with that,
        and is not farther behind than orders that were late account for. `let_pass` is how far off
        nobody doubts it, `least` how far it must have turned for it to count.
        """
        if math.isinf(self.heard_s):
            return True
        way = math.copysign(1.0, self._apart)
        turned, apart = way * (count - self._count), abs(place - count)
        ran = way * (place - self._count - self._apart)
        nearer = apart < abs(self._apart) - least
        paced = turned >= PACE * ran and apart <= FOLLOWED * let_pass
        return turned > least and (nearer or paced)

    def note(self, count: int, place: float, now_s: float) -> None:
        """Take note of where it was found, and where it should have been."""
        self.heard_s, self._count, self._apart = now_s, count, place - count
