"""What the flight recorder costs: `python benchmarks/recorder.py [--json]`.

Each figure is measured with the recorder and without it in turn, and stands beside its ratio.
"""

from __future__ import annotations

import contextlib
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import cast

from measuring import Row, Section, interleaved, own_home, ratio, report

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry import DIALECTS
from armdrive.trace.recorder import FlightRecorder

BARE = "without"
MOVE_DEG = 8.0


class Ignoring:
    """Stands in for a recorder, and does nothing."""

    def __getattr__(self, name: str) -> Ignoring:
        return self

    def __call__(self, *_: object, **__: object) -> None:
        """Do nothing, whatever is called."""


class Swapped:
    """One connected arm, whose recorder can be taken away and given back between two calls."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.recorder = arm.parts.tracer
        self._side = 1.0

    def traced_by(self, tracer: FlightRecorder | Ignoring, call: Callable[[], object]) -> None:
        """Do something while this one looks."""
        arm = self.arm
        with arm.parts.pace.lock:
            arm._parts = replace(arm.parts, tracer=cast(FlightRecorder, tracer))
            arm.parts.core.tracer = arm.parts.engine.tracer = arm.parts.tracer
        call()

    def move(self) -> None:
        """Move to the other side."""
        self._side = -self._side
        self.arm.move_j(base_deg=self._side * MOVE_DEG)

    def cases(self, call: Callable[[], object]) -> dict[str, Callable[[], object]]:
        """Return the call with the recorder and without it."""
        return {
            "with": lambda: self.traced_by(self.recorder, call),
            BARE: lambda: self.traced_by(Ignoring(), call),
        }


@contextlib.contextmanager
def _simulated(dialect: str) -> Iterator[Swapped]:
    arm = Arm(connect_simulated(simulated_config(dialect), tracer=FlightRecorder()))
    with arm:
        arm.home()
        arm.move_j(shoulder_deg=30)
        yield Swapped(arm)


def cpu(rounds: int = 30, dialects: Iterable[str] = tuple(DIALECTS)) -> Section:
    """Measure the same move on simulated time: whatever it takes is CPU."""
    rows = []
    for dialect in dialects:
        with _simulated(dialect) as swapped:
            before = swapped.arm.parts.engine.now_s
            taken = interleaved(swapped.cases(swapped.move), rounds)
            moved_s = (swapped.arm.parts.engine.now_s - before) / (2 * rounds + 2)
        with_s, bare_s = taken["with"], taken[BARE]
        added_s = median(with_s) - median(bare_s)
        rows += [
            Row(f"{dialect}: a move without the recorder", median(bare_s) * 1e3, "ms of CPU"),
            Row(
                f"{dialect}: with it",
                median(with_s) * 1e3,
                "ms of CPU",
                times={
                    "without it": ratio(with_s, bare_s),
                    f"the {moved_s:.2f} s that the move lasts": median(with_s) / moved_s,
                },
            ),
            Row(f"{dialect}: added to each second of motion", added_s / moved_s * 1e3, "ms of CPU"),
        ]
    return Section(
        "CPU of a move",
        tuple(rows),
        f"{2 * MOVE_DEG:g} degrees of the base, {rounds} times each, driver and simulated arm "
        "together on simulated time",
    )


def writing(seconds: float = 400.0) -> Section:
    """Measure a full ring: how long it keeps the wire's thread, and how long writing takes."""
    with _simulated("grbl") as swapped, tempfile.TemporaryDirectory() as folder:
        arm = swapped.arm
        end_s = arm.parts.engine.now_s + seconds
        while arm.parts.engine.now_s < end_s:
            swapped.move()
        began_s = time.perf_counter()
        write = arm.parts.tracer.snapshot("measured")
        held_s = time.perf_counter() - began_s
        path = write(Path(folder) / "recording.jsonl")
        written_s = time.perf_counter() - began_s
        size = path.stat().st_size
        entries = path.read_bytes().count(b"\n")
    rows = (
        Row("entries in the last five minutes", entries, ""),
        Row("memory, as the ring counts it", arm.parts.tracer.ring.bytes / 1e6, "MB"),
        Row("the file", size / 1e6, "MB"),
        Row("the wire's thread is held", held_s * 1e3, "ms"),
        Row("written and synced, by another thread", written_s * 1e3, "ms"),
    )
    return Section("Writing it out", rows, "a GRBL board that moves all the time")


SECTIONS: Mapping[str, Callable[[], Section]] = {
    "cpu": cpu,
    "writing": writing,
}


def main(argv: list[str] | None = None) -> int:
    """Run the sections that are asked for, or all of them."""
    with own_home():
        return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
