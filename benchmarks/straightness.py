"""Print how far each simulated arm's tip leaves its lines: `python benchmarks/straightness.py`.

On simulated time, the physical tip is looked at every 4 ms, at the ends of bursts and between
them. Promised are `motion.line_tolerance_mm` and what a motor step is worth at that place; on a
device that does not coordinate its motors also `deviation_mm` of the move, between bursts. Exit
code 1 where the tip was further off.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

from feel import Figures, Measured, Options, report
from feel_benches import DenseMemoryBench, chance
from feel_ways import KINDS, Way, ways

from kinematics import Motors
from tests.conformance.rows_moving import line_allowance_mm

TIMES, QUICK_TIMES = 40, 1
PATIENCE_S = 120.0
SLOWEST = 0.3


@dataclass(frozen=True, slots=True)
class Drawn:
    """How one line came out: the worst at the ends of bursts, the worst anywhere."""

    at_ends: Measured
    anywhere: Measured


def drawn(bench: DenseMemoryBench, way: Way, speed: float) -> Drawn:
    """Have a line drawn from where the arm stands, and look at the physical tip all the way."""
    arm = bench.arm
    assert arm is not None
    handle = way.begin(arm, speed)
    seen: set[Motors] = set()
    ends: set[Motors] = set()
    for each in bench.watch(lambda: handle.done, PATIENCE_S):
        seen.add(each.motors)
        if each.motors == arm.parts.core.position.acknowledged:
            ends.add(each.motors)
    moved = handle.wait()
    return Drawn(_worst(bench, way, ends, 0.0), _worst(bench, way, seen, moved.deviation_mm))


def _worst(bench: DenseMemoryBench, way: Way, places: set[Motors], deviation_mm: float) -> Measured:
    """Return the place that uses most of what is allowed there."""
    found = (
        Measured(
            way.off_mm(bench.tip(motors)),
            line_allowance_mm(bench.config, bench.step_mm(motors), deviation_mm),
        )
        for motors in places
    )
    return max(found, key=lambda each: each.value / each.bound, default=Measured(0.0, 1.0))


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """Draw every kind of line on a dialect's twin."""
    with DenseMemoryBench(dialect) as bench:
        arm = bench.ready()
        # a device that drives what is queued past the ends of segments has no ends to look at
        apart = not arm.abilities.queued_segments
        for kind in KINDS:
            luck = chance(dialect, kind)
            found = []
            for way in ways(arm, kind, luck, options.times):
                bench.bring(way.start)
                found.append(drawn(bench, way, luck.uniform(SLOWEST, 1.0)))
            if apart:
                ends = [each.at_ends for each in found]
                yield Figures(dialect, f"{kind}: at the ends of bursts", "mm", ends)
            yield Figures(dialect, f"{kind}: anywhere", "mm", [each.anywhere for each in found])


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(
        argv, __doc__, measure, times=TIMES, quick_times=QUICK_TIMES, clocks=("simulated",)
    )


if __name__ == "__main__":
    sys.exit(main())
