"""Print how much of its wire and its time a simulated arm uses: `python benchmarks/wire_use.py`.

A long path at full speed, of lines and arcs with blends, or one joint motion where the driver may
draw no line. From when the physical arm begins to move to when it last stops: for which share of
the time motors turn, beside what the wire alone would allow (`expected_share`); how much of
the wire each way is used; how long the arm stands between bursts. A device that queues should not
stand at all: each standstill is an underrun, and exit code 1.

`--real` (the usual): a twin in another process, over a pty, its bytes paced as on the line.
`--simulated`: on simulated time, the same in every run.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

from feel import Figures, Measured, Options, report
from feel_benches import DenseMemoryBench, DensePtyBench, knows_lines

from armdrive.abilities import BITS_A_BYTE, segment_s
from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.motion.execute import Moved
from kinematics import LinePart, Pose
from kinematics.paths.routes import ArcPart, PathPart

TIMES, QUICK_TIMES = 5, 1
PATIENCE_S = 300.0
BLEND_MM = 15.0
START = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-70)


@dataclass(frozen=True, slots=True)
class Trip:
    """What one journey along the path was: times in s, bytes both ways."""

    lasted_s: float
    moving_s: float
    pauses_s: tuple[float, ...]
    sent: int
    heard: int
    bursts: int


class Counted:
    """Counts the bytes that pass a driver's wire, each way."""

    def __init__(self, arm: Arm) -> None:
        self.sent = self.heard = 0
        link = arm.parts.engine.link
        write, read = link.write, link.read

        def counted_write(data: bytes, now_s: float) -> None:
            self.sent += len(data)
            write(data, now_s)

        def counted_read(now_s: float) -> bytes:
            data = read(now_s)
            self.heard += len(data)
            return data

        link.write, link.read = counted_write, counted_read  # type: ignore[method-assign]


class QuickBench(DenseMemoryBench):
    """Looked at every ms, lest a short pause is missed."""

    look_s: ClassVar[float] = 0.001


def path() -> list[PathPart]:
    """Return a long path from a pose over the table, and back to it."""

    def at(x_mm: float, y_mm: float, z_mm: float, pitch_deg: float = -70.0) -> Pose:
        return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=pitch_deg)

    return [
        LinePart(at(250, 120, 120), BLEND_MM),
        LinePart(at(180, 120, 150), BLEND_MM),
        ArcPart(at(220, 0, 180), at(180, -120, 150), BLEND_MM),
        LinePart(at(250, -120, 120), BLEND_MM),
        LinePart(at(250, 120, 120, -90.0), BLEND_MM),
        LinePart(at(200, 0, 150)),
    ]


def begin(arm: Arm, *, lines: bool, quick: bool) -> Handle[Moved]:
    """Bring the arm to where the path begins, and begin it, or a little of it."""
    if not lines:
        arm.move_j(base_deg=0.0, shoulder_deg=40.0, elbow_deg=-70.0)
        far = 0.1 if quick else 1.0
        return arm.move_j(base_deg=75.0 * far, shoulder_deg=40.0 + 20.0 * far, wait=False)
    arm.move_to(START)
    moves = [LinePart(replace(START, y_mm=30.0))] if quick else path()
    return arm.move_path(moves, wait=False)


def trip(bench: DenseMemoryBench | DensePtyBench, arm: Arm, wire: Counted, *, quick: bool) -> Trip:
    """Go along the path once, and watch the motors."""
    handle = begin(arm, lines=knows_lines(bench), quick=quick)
    spans: list[list[float]] = []  # from, until: while motors turn
    turned = False
    wire.sent = wire.heard = 0
    for seen in bench.watch(lambda: handle.done, PATIENCE_S):
        if bench.turning and not turned:
            spans.append([seen.time_s, seen.time_s])
        elif bench.turning or turned:
            spans[-1][1] = seen.time_s
        turned = bench.turning
    moved = handle.wait()
    return Trip(
        spans[-1][1] - spans[0][0],
        sum(until_s - from_s for from_s, until_s in spans),
        tuple(after[0] - before[1] for before, after in itertools.pairwise(spans)),
        wire.sent,
        wire.heard,
        moved.bursts,
    )


def expected_share(arm: Arm) -> float:
    """Return the share of the time in motion that the wire allows."""
    able, burst_s = arm.abilities, arm.config.motion.planned_burst_s
    baud = arm.config.connection.baud
    if able.queued_segments:
        return min(1.0, segment_s(burst_s) / able.traffic.line_s(baud))
    return burst_s / (burst_s + able.traffic.exchange_s(baud))


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """Go along the path so many times."""
    bench = QuickBench(dialect) if options.simulated else DensePtyBench(dialect)
    with bench:
        arm = bench.ready()
        wire = Counted(arm)
        trips = [trip(bench, arm, wire, quick=options.quick) for _ in range(options.times)]
        byte_s = BITS_A_BYTE / arm.config.connection.baud
        queues = bool(arm.abilities.queued_segments)
        expected = expected_share(arm)
        counted = arm.status.underruns

    def shares(what: str, values: Iterator[float]) -> Figures:
        return Figures(dialect, what, "%", [Measured(value * 100.0) for value in values])

    yield shares("in motion", (each.moving_s / each.lasted_s for each in trips))
    yield shares("  what the wire alone would allow", iter((expected,)))
    yield shares("the wire to the device", (each.sent * byte_s / each.lasted_s for each in trips))
    back = (each.heard * byte_s / each.lasted_s for each in trips)
    yield shares("the wire from the device", back)
    pauses = [pause_s for each in trips for pause_s in each.pauses_s]
    yield Figures(dialect, "stands between bursts", "ms", [Measured(p * 1e3) for p in pauses])
    yield Figures(dialect, "requests of one path", "", [Measured(each.bursts) for each in trips])
    yield Figures(dialect, "one path", "s", [Measured(each.lasted_s) for each in trips])
    if queues:
        seen = [Measured(len(each.pauses_s), 0.0) for each in trips]
        yield Figures(dialect, "underruns: standstills of the physical arm", "", seen)
        yield Figures(dialect, "underruns that the status counts", "", [Measured(counted, 0.0)])


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(
        argv,
        __doc__,
        measure,
        times=TIMES,
        quick_times=QUICK_TIMES,
        clocks=("real", "simulated"),
    )


if __name__ == "__main__":
    sys.exit(main())
