"""Whether memory leaks: it keeps growing in the later half of a run. A cache that fills is no leak.

Figures are hours and kB. A bounded cache fills early and then more slowly; a leak goes on at the
same rate. So only the later half of the run gives the trend: the median of the slopes between all
pairs of figures, which one or two outliers do not change (P. K. Sen, "Estimates of the regression
coefficient based on Kendall's tau", 1968).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from statistics import median

FEWEST = 4
"""A trend needs at least this many figures."""

Look = tuple[float, float]
"""Hours and kB."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """How much one kind of figure may rise: by its trend in the later half, and in all."""

    what: str
    trend_kb: float
    total_kb: float


BETWEEN = Allowance("memory between two programs", 24.0, 128.0)
"""Nothing of a program is left between two programs: figures differ by some 3 kB. The rest is for
caches that fill late, and for the figures themselves."""

WITHIN = Allowance("memory of the running program", 256.0, 1024.0)
"""The flight recorder keeps five minutes, which differ by some 100 kB, and up to 250 kB of
settings."""

PROCESS = Allowance("memory of the process", 2048.0, 4096.0)
"""Python takes memory from the system by the MB, and the figure is the most that it ever had, so
each rare maximum stays."""


def trend_kb(looks: Sequence[Look]) -> float:
    """Return how much the later half of the figures rises, from its first to its last."""
    later = looks[len(looks) // 2 :]
    if len(later) < FEWEST:
        return 0.0
    slopes = ((b - a) / (t - s) for (s, a), (t, b) in combinations(later, 2) if t > s)
    return median(slopes) * (later[-1][0] - later[0][0])


def risen_kb(looks: Sequence[Look]) -> float:
    """Return by how much the median of the last third of the figures is above the first figure."""
    last = looks[-max(len(looks) // 3, 1) :]
    return median(kb for _, kb in last) - looks[0][1]


def judged(looks: Sequence[Look], allowed: Allowance) -> list[str]:
    """Return what is wrong with the figures of a run after its warm-up."""
    wrong = []
    if (trend := trend_kb(looks)) > allowed.trend_kb:
        hours = looks[-1][0] - looks[len(looks) // 2][0]
        wrong.append(
            f"{allowed.what} keeps growing: {trend:.0f} kB in the last {hours:.1f} h, "
            f"allowed {allowed.trend_kb:.0f}"
        )
    if (risen := risen_kb(looks)) > allowed.total_kb:
        wrong.append(
            f"{allowed.what} has grown by {risen:.0f} kB since it was warm, "
            f"allowed {allowed.total_kb:.0f}"
        )
    return wrong
