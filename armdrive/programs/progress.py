"""How far a run has come, and what is left of it, by what its rehearsal took.

A run may go another way than its rehearsal, an input may be on that was taken to be off: it is
looked for where it is again, by its place in the program. Units: s on the arm's own clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, chain

from armdrive.programs.problems import SourceMark

FOR_EVER = 0
"""So many loops have no end."""

LOOPS_REHEARSED = 2
"""The second loop begins where the first has ended, and so do all that follow."""


@dataclass(frozen=True, slots=True)
class Took:
    """What one act of a rehearsal took, and where it stands in the program."""

    mark: SourceMark
    what: str
    took_s: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """How far a run has come. `percent` and `left_s` are None where nobody knows.

    Of a run without an end, both are of its present loop.
    """

    percent: float | None = None
    left_s: float | None = None


UNKNOWN = Estimate()


class RunProgress:
    """Follows a run along its rehearsal."""

    def __init__(self, loops: Sequence[Sequence[Took]], *, repeated: int = 1) -> None:
        """Take the rehearsed loops, of which the last stands for all that follow.

        `repeated` is how many loops the run has, `FOR_EVER` for no end. Without any rehearsed
        loop, nothing is known.
        """
        self._loops = [list(loop) for loop in loops]
        self._ends_s = [list(accumulate(each.took_s for each in loop)) for loop in self._loops]
        self._repeated = repeated
        self._loop = 0
        self._index: int | None = None

    @property
    def total_s(self) -> float | None:
        """How long the whole run takes; None of one without an end, or that nobody knows."""
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

        `share` is how fast the arm goes now, of the speed that it was rehearsed with.
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
    """Return the index of a mark: the first from where it is expected on, else the last before.

    None where it is nowhere.
    """
    ahead = range(expected, len(marks))
    behind = range(min(expected, len(marks)) - 1, -1, -1)
    return next((index for index in chain(ahead, behind) if marks[index] == mark), None)
