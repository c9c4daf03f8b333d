"""Print how evenly a long path is streamed to MKS drives: `python benchmarks/can_streaming.py`.

In real time, for about a minute each: six drives in another process behind a serial CAN adapter on
a pty, steered at 25 (the usual), 50 and 100 targets a second each along lines and arcs with blends.
Measured is when the first frame of each round has been given to the adapter. Beside the period
stands a bare thread in a process of its own, which sleeps to absolute deadlines at the same time.
A period longer than what is sent ahead has the drives brake: that is the bound, and exit code 1.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from can_strategies import DIALECT, MEASURED
from feel import Figures, Measured, Options, report
from feel_benches import DensePtyBench
from tapping import tapped
from wire_use import START, path

from armdrive.arm import Arm
from armdrive.errors import ArmError
from armdrive.flows.motion import Moved
from armdrive.handle import Handle
from armdrive.transports.can_timing import frame_bits
from firmware_protocol.frames import Frame, Unpacker
from firmware_protocol.mks import Code
from kinematics import LineMove

TIMES, QUICK_TIMES = 4, 1
"""Laps of the path; one takes about seventeen seconds."""

PERIODS_S = {"25 Hz": 0.04, "50 Hz": 0.02, "100 Hz": 0.01}
SHORT = [LineMove(replace(START, y_mm=20.0)), LineMove(START)]
MISSED = 1.5
"""A period this many times too long has missed its deadline."""

BARE = """
import sys, time, json
period_s, found = float(sys.argv[1]), []
sys.stdin.readline()
due_s = last_s = time.monotonic()
import select
while True:
    due_s += period_s
    if select.select([sys.stdin], [], [], max(due_s - time.monotonic(), 0.0))[0]:
        break
    now_s = time.monotonic()
    found.append(now_s - last_s)
    last_s = now_s
print(json.dumps(found))
"""


@dataclass(slots=True)
class Wire:
    """What passed a driver's adapter: frames and, of those sent, when they had been."""

    bits: int = 0
    frames: int = 0
    orders: list[tuple[float, int]] = field(default_factory=list)
    """Each order for a motion: when it had been handed over, and to which drive."""

    def sent(self, frames: list[Frame], time_s: float) -> None:
        """Note frames that have gone out."""
        self.heard(frames)
        order = bytes((Code.ABSOLUTE_AXIS,))
        self.orders += [(time_s, each.can_id) for each in frames if each.data[:1] == order]

    def heard(self, frames: list[Frame]) -> None:
        """Note frames that have come in."""
        self.bits += sum(map(frame_bits, frames))
        self.frames += len(frames)

    def periods_s(self) -> list[float]:
        """Return the times from one round of orders to the next; rounds go up through the ids."""
        starts = [self.orders[0][0]] if self.orders else []
        for before, after in itertools.pairwise(self.orders):
            if after[1] <= before[1]:
                starts.append(after[0])
        return [b - a for a, b in itertools.pairwise(starts)]


@contextlib.contextmanager
def watched(arm: Arm) -> Iterator[Wire]:
    """Note all that passes the adapter of an arm."""
    wire, link = Wire(), arm.engine.link
    of_host, of_drives = Unpacker(), Unpacker()
    read = link.read

    def noted_read(now_s: float) -> bytes:
        data = read(now_s)
        wire.heard(of_drives.feed(data))
        return data

    link.read = noted_read  # type: ignore[method-assign]
    with tapped(arm, lambda data: wire.sent(of_host.feed(data), time.monotonic())):
        yield wire
    link.read = read  # type: ignore[method-assign]


class BareThread:
    """A program that does nothing but wake at a period."""

    def __init__(self, period_s: float) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-S", "-c", BARE, str(period_s)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def begin(self) -> None:
        """Have it begin."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()

    def end(self) -> list[float]:
        """End it, and return its periods."""
        told, _ = self._process.communicate("\n", timeout=30.0)
        return json.loads(told)


def measure(options: Options, rate: str) -> Iterator[Figures]:
    """Stream so many laps."""
    period_s = PERIODS_S[rate]
    lines = f"{MEASURED}[{DIALECT}]\nsegment_s = {period_s}\n"
    with DensePtyBench(DIALECT) as bench:
        bench.fit(lines)
        arm = bench.ready()
        arm.move_to(START)
        lap = SHORT if options.quick else path()
        bare = BareThread(period_s)
        with watched(arm) as wire:
            bare.begin()
            began_s, began_cpu_s = time.monotonic(), time.process_time()
            handle = arm.move_path(lap * options.times, wait=False)
            fault = ended(handle)
            cpu_s = time.process_time() - began_cpu_s
            wall_s = time.monotonic() - began_s
        floor = bare.end()
        ahead_s = arm.config.motion.planned_burst_s
        underruns, bits_s = arm.status.underruns, arm.config.connection.baud
    periods = wire.periods_s()
    yield Figures(rate, "a bare thread: from one deadline to the next", "ms", _ms(floor))
    yield Figures(rate, "  deadlines that it missed", "", [_missed(floor, period_s)])
    yield Figures(rate, "from one round of targets to the next", "ms", _ms(periods, ahead_s))
    yield Figures(rate, "  deadlines that were missed", "", [_missed(periods, period_s)])
    yield Figures(rate, "underruns that the status counts", "", [Measured(underruns, 0.0)])
    bus_share = wire.bits / bits_s / wall_s
    yield Figures(rate, "one core, used by the driver", "%", [Measured(cpu_s / wall_s * 100.0)])
    yield Figures(rate, "the bus, used both ways", "%", [Measured(bus_share * 100.0, 100.0)])
    yield Figures(rate, "frames a second", "", [Measured(wire.frames / wall_s)])
    yield Figures(rate, "the motion", "s", [Measured(wall_s)])
    yield Figures(rate, f"motions that ended in a fault{fault}", "", [Measured(bool(fault), 0.0)])


def ended(handle: Handle[Moved]) -> str:
    """Wait for the end of a motion; return what went wrong, empty where nothing did."""
    try:
        handle.wait()
    except ArmError as error:
        return f": {error}"
    return ""


def _missed(found: list[float], period_s: float) -> Measured:
    return Measured(sum(each > MISSED * period_s for each in found))


def _ms(found: list[float], bound_s: float = float("inf")) -> list[Measured]:
    return [Measured(each * 1e3, bound_s * 1e3) for each in found]


def main(argv: list[str] | None = None) -> int:
    """Measure every rate, or those that are asked for."""
    return report(argv, __doc__, measure, dialects=PERIODS_S, times=TIMES, quick_times=QUICK_TIMES)


if __name__ == "__main__":
    sys.exit(main())
