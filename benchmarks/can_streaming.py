"""Print how evenly a long path is streamed to drives on a bus: `benchmarks/can_streaming.py`.

    python benchmarks/can_streaming.py [mks | cia402 | "100 Hz" ...] [--times N] [--quick] [--json]

In real time, for about a minute each: six drives in another process behind a serial CAN adapter on
a pty, steered along lines and arcs with blends; MKS drives by 25 (the usual), 50 and 100 targets a
second each, CiA 402 drives by cyclic synchronous position (CSP) with 50 and 100 (the usual).
Measured is when the first frame of each round has been given to the adapter, or the SYNC that makes
it valid. Beside the period stands a bare thread in a process of its own, which sleeps to absolute
deadlines at the same time. A period longer than what drives wait for has them brake: that is the
bound, and exit code 1. Drives that tell their position at each SYNC are held to their targets.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

from can_rounds import watched
from can_strategies import RATES, groups, measured
from feel import Figures, Measured, Options, report
from feel_benches import DensePtyBench
from wire_use import START, path

from armdrive.arm.connected import Handle
from armdrive.errors import ArmError
from armdrive.motion.execute import Moved
from kinematics import LinePart

TIMES, QUICK_TIMES = 4, 1
"""Laps of the path; one takes about seventeen seconds."""

PERIODS_S = {name: 1.0 / float(name.removeprefix("CSP ").removesuffix(" Hz")) for name in RATES}
SHORT = [LinePart(replace(START, y_mm=20.0)), LinePart(START)]
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
        periods_s: list[float] = json.loads(told)
        return periods_s


def measure(options: Options, rate: str) -> Iterator[Figures]:
    """Stream so many laps."""
    period_s, strategy = PERIODS_S[rate], RATES[rate]
    with DensePtyBench(strategy.dialect) as bench:
        bench.use_arm_file(measured(strategy.dialect) + strategy.section())
        arm = bench.ready()
        arm.move_to(START)
        lap = SHORT if options.quick else path()
        bare, before = BareThread(period_s), arm.status.underruns
        with watched(arm) as wire:
            bare.begin()
            began_s, began_cpu_s = time.monotonic(), time.process_time()
            handle = arm.move_path(lap * options.times, wait=False)
            fault = ended(handle)
            cpu_s = time.process_time() - began_cpu_s
            wall_s = time.monotonic() - began_s
        floor = bare.end()
        rounds = wire.rounds()
        longest_s = rounds.longest_s(arm)
        underruns, bits_s = arm.status.underruns - before, arm.config.connection.baud
    periods = rounds.periods_s()
    yield Figures(rate, "a bare thread: from one deadline to the next", "ms", _ms(floor))
    yield Figures(rate, "  deadlines that it missed", "", [_missed(floor, period_s)])
    yield Figures(rate, "from one round of targets to the next", "ms", _ms(periods, longest_s))
    yield Figures(rate, "  deadlines that were missed", "", [_missed(periods, period_s)])
    yield Figures(rate, "underruns that the status counts", "", [Measured(underruns, 0.0)])
    if rounds.behind:
        window = getattr(arm.config.device, "following_window", math.inf)
        behind = [Measured(each, window) for each in rounds.behind]
        yield Figures(rate, "a drive from its target at the SYNC behind", "inc", behind)
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
    return report(
        argv,
        __doc__,
        measure,
        dialects=RATES,
        times=TIMES,
        quick_times=QUICK_TIMES,
        groups=groups(RATES),
    )


if __name__ == "__main__":
    sys.exit(main())
