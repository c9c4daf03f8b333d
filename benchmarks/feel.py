"""How the benchmarks of feel are called, and how they print: p50, p99, worst, beside the bound.

Every value has a bound of its own. `bound` is that of the value that came nearest to its own, and
`nearest` how near.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from types import MappingProxyType

from measuring import machine, own_home, p99

from armdrive.registry import DIALECTS

SEED = 1982
HEAD = ("dialect", "what", "n", "p50", "p99", "worst", "bound", "nearest", "")
WIDTHS = (12, 56, 7, 10, 10, 10, 10, 9, 0)


@dataclass(frozen=True, slots=True)
class Measured:
    """One value, and what was promised of it at that moment; without a promise, infinity."""

    value: float
    bound: float = math.inf


@dataclass(frozen=True, slots=True)
class Figures:
    """Everything that was measured of one thing on one dialect."""

    dialect: str
    what: str
    unit: str
    found: Sequence[Measured]

    @property
    def kept(self) -> bool:
        """Whether every value is within its own bound."""
        return all(each.value <= each.bound for each in self.found)

    @property
    def nearest(self) -> float:
        """The share of its bound that the worst of them has used."""
        return max(map(_used, self.found), default=0.0)

    @property
    def bound(self) -> float:
        """The bound of the one that has come nearest to its own."""
        nearest = max(self.found, key=_used, default=Measured(0.0))
        return nearest.bound

    def as_json(self) -> dict[str, object]:
        """Return the figures as plain data."""
        values = [each.value for each in self.found] or [math.nan]
        bound = self.bound
        return {
            "dialect": self.dialect,
            "what": self.what,
            "unit": self.unit,
            "n": len(self.found),
            "p50": median(values),
            "p99": p99(values),
            "worst": max(values),
            "bound": bound if math.isfinite(bound) else None,
            "nearest": self.nearest,
            "kept": self.kept,
        }

    def __str__(self) -> str:
        if not self.found:
            return padded((self.dialect, self.what, "0", *("-",) * 5, ""))
        values = [each.value for each in self.found]
        bounded = math.isfinite(self.bound)
        return padded(
            (
                self.dialect,
                self.what,
                str(len(values)),
                *(self._shown(value) for value in (median(values), p99(values), max(values))),
                self._shown(self.bound) if bounded else "-",
                f"{self.nearest:.0%}" if bounded else "-",
                "" if self.kept else "ABOVE ITS BOUND",
            )
        )

    def _shown(self, value: float) -> str:
        return f"{value:.{1 if self.unit == 'ms' else 2}f} {self.unit}"


def _used(each: Measured) -> float:
    """Return the share of its bound that a value has used; a bound of nothing is kept or not."""
    if each.bound:
        return each.value / each.bound
    return math.inf if each.value else 0.0


def padded(cells: Sequence[str], widths: Sequence[int] = WIDTHS) -> str:
    """Return cells in columns."""
    return "".join(f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True)).rstrip()


@dataclass(frozen=True, slots=True)
class Options:
    """What was asked for: how often each is done, in real time or not, and with what else."""

    dialects: tuple[str, ...]
    times: int
    quick: bool
    simulated: bool


Measure = Callable[[Options, str], Iterable[Figures]]


def report(
    argv: list[str] | None,
    description: str | None,
    measure: Measure,
    *,
    dialects: Iterable[str] = tuple(DIALECTS),
    times: int,
    quick_times: int,
    clocks: Sequence[str] = ("real",),
    groups: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> int:
    """Measure dialect by dialect, print every row, and return 1 where a bound is broken.

    The first of `clocks` is the usual one; with both, `--simulated` and `--real` choose. The name
    of one of the `groups` stands for all that is in it.
    """
    known = tuple(dialects)
    parser = argparse.ArgumentParser(description=(description or "").partition("\n")[0])
    names = ", ".join((*groups, *known))
    parser.add_argument("dialects", nargs="*", metavar="DIALECT", help=names)
    parser.add_argument("--times", type=int, help=f"how often each is done ({times})")
    parser.add_argument("--quick", action="store_true", help=f"{quick_times} times each")
    parser.add_argument("--json", action="store_true", help="print JSON lines")
    for clock in clocks if len(clocks) > 1 else ():
        parser.add_argument(f"--{clock}", dest="clock", action="store_const", const=clock)
    parser.set_defaults(clock=clocks[0])
    given = parser.parse_args(argv)
    asked = tuple(name for each in given.dialects for name in groups.get(each, (each,)))
    if unknown := set(asked) - set(known):
        parser.error(f"nothing is measured of {min(unknown)}; there are {names}")
    count = given.times or (quick_times if given.quick else times)
    options = Options(asked or known, count, given.quick, given.clock == "simulated")
    head = f"{machine()}; {given.clock} time"
    print(json.dumps({"machine": head}) if given.json else f"{head}\n{padded(HEAD)}")
    kept = True
    with own_home():
        for dialect in options.dialects:
            for figures in measure(options, dialect):
                print(json.dumps(figures.as_json()) if given.json else figures, flush=True)
                kept = kept and figures.kept
    return 0 if kept else 1
