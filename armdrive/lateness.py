"""How late a thread wakes for its deadlines: a small histogram, and what it says in words.

Deadlines are absolute: a late one does not make the next one late. What is counted is how long
after a deadline the thread went on, in classes that grow by about two.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field

EDGES_S = (
    20e-6, 50e-6, 100e-6, 200e-6, 500e-6, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3, 0.1, 0.2, 0.5, 1.0,
)  # fmt: skip
"""Upper ends of the classes; what is later is in one more."""


@dataclass(frozen=True, slots=True)
class Wakes:
    """How late a thread woke, in s: upper ends of the classes that half and 99 % lie in."""

    count: int = 0
    median_s: float = 0.0
    p99_s: float = 0.0
    worst_s: float = 0.0
    classes: tuple[int, ...] = ()

    def __str__(self) -> str:
        if not self.count:
            return "no deadline has passed"
        return (
            f"{self.count} deadlines, half met within {_ms(self.median_s)}, 99 % within "
            f"{_ms(self.p99_s)}, the latest {_ms(self.worst_s)} late"
        )


NEVER_WOKEN = Wakes()


@dataclass(slots=True)
class Lateness:
    """Counts; touched by one thread."""

    counts: list[int] = field(default_factory=lambda: [0] * (len(EDGES_S) + 1))
    worst_s: float = 0.0

    def add(self, late_s: float) -> None:
        """Note that a deadline was met so late; what is early is not late."""
        late_s = max(late_s, 0.0)
        self.counts[bisect_left(EDGES_S, late_s)] += 1
        self.worst_s = max(self.worst_s, late_s)

    def view(self) -> Wakes:
        """Return what has been counted so far."""
        total = sum(self.counts)
        if not total:
            return NEVER_WOKEN
        half_s, most_s = self._within_s(0.5, total), self._within_s(0.99, total)
        return Wakes(total, half_s, most_s, self.worst_s, tuple(self.counts))

    def _within_s(self, share: float, total: int) -> float:
        """Return within what this share of the deadlines was met; never more than the worst."""
        seen = 0
        for count, edge_s in zip(self.counts, EDGES_S, strict=False):
            seen += count
            if seen >= share * total:
                return min(edge_s, self.worst_s)
        return self.worst_s


def _ms(time_s: float) -> str:
    return f"{time_s * 1e3:.2g} ms" if time_s < 0.1 else f"{time_s * 1e3:.0f} ms"
