"""How far a run has come and how long it still takes, estimated from its rehearsal.

A run may take another path than its rehearsal, if an input is on that was assumed off. Then it is
found again by its place in the program. Units: s on the arm's clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, chain

from armdrive.programs.problems import SourceMark

FOR_EVER = 0
"""The number of loops that means endless."""

LOOPS_REHEARSED = 2
"""The second loop begins where the first ended, and so do all others."""


@dataclass(frozen=True, slots=True)
class Took:
    """How long one act of a rehearsal took, and its place in the program."""

    mark: SourceMark
    what: str
    took_s: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """How far a run has come. `percent` and `left_s` are None if unknown.

    For an endless run both are those of the present loop.
    """

    percent: float | None = None
    left_s: float | None = None


UNKNOWN = Estimate()


class RunProgress:
    """Follows a run along its rehearsal."""

    def __init__(self, loops: Sequence[Sequence[Took]], *, repeated: int = 1) -> None:
        """Take the rehearsed loops, the last of which stands for all later ones.

        `repeated` is how many loops the run has, or `FOR_EVER`. Without a rehearsed loop nothing is
        known.
        """
        self._loops = [list(loop) for loop in loops]
        self._ends_s = [list(accumulate(each.took_s for each in loop)) for loop in self._loops]
        self._repeated = repeated
        self._loop = 0
        self._index: int | None = None

    @property
    def total_s(self) -> float | None:
        """How long the whole run takes; None if it is endless or unknown."""
        if self._repeated == FOR_EVER or not self._loops:
            return None
        return sum(self._loop_s(number) for number in range(1, self._repeated + 1))

    def begins(self, mark: SourceMark, loop: int = 1) -> None:
        """Note where the run is now."""
        fresh, self._loop = loop != self._loop, loop
        marks = [each.mark for each in self._rehearsed(loop)]
        expected = 0 if fresh or self._index is None else self._index + 1
        self._index = nearest(marks, mark, expected)

    def estimate(self, under_way_s: float, share: float = 1.0) -> Estimate:
        """Return how far the run has come, `under_way_s` after the present act began.

        `share` is the present speed as a share of the rehearsed speed.
        """
        if self._index is None or not self._loops:
            return UNKNOWN
        took_s = self._rehearsed(self._loop)[self._index].took_s
        done_s = self._ends(self._loop)[self._index] - took_s + min(under_way_s * share, took_s)
        whole_s = self._loop_s(self._loop)
        if self._repeated != FOR_EVER:
            done_s += sum(self._loop_s(number) for number in range(1, self._loop))
            whole_s = sum(self._loop_s(number) for number in range(1, self._repeated + 1))
        percent = 100.0 * done_s / whole_s if whole_s > 0.0 else 0.0
        return Estimate(min(percent, 100.0), max(whole_s - done_s, 0.0) / share)

    def _rehearsed(self, loop: int) -> list[Took]:
        return self._loops[min(loop, len(self._loops)) - 1] if self._loops else []

    def _ends(self, loop: int) -> list[float]:
        return self._ends_s[min(loop, len(self._loops)) - 1]

    def _loop_s(self, loop: int) -> float:
        return (self._ends(loop) or [0.0])[-1]


def nearest(marks: Sequence[SourceMark], mark: SourceMark, expected: int) -> int | None:
    """Return the index of a mark: the first at or after `expected`, else the last before it.

    Returns None if there is none.
    """
    ahead = range(expected, len(marks))
    behind = range(min(expected, len(marks)) - 1, -1, -1)
    return next((index for index in chain(ahead, behind) if marks[index] == mark), None)
