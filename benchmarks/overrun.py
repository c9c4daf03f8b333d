"""How long and how far the physical arm goes on in real time, compared with the announced bounds.

The arm is simulated in another process, over a pty. A third process drives it, and releases a jog,
stops a motion, or is killed.
"""

import contextlib
import json
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from tests.conformance.observation import Observation
from tests.conformance.real_time_bench import ProcessBench, PtyBench

ROOT = Path(__file__).parents[1]
SEED = 1982
MOMENTS_S = (0.15, 0.6)
"""The range from which it is drawn how long the arm moves before it is stopped."""

LOOK_S = PtyBench.look_s
"""The resolution of the measured times."""


@dataclass(frozen=True, slots=True)
class StopMeasurement:
    """One stop: the bounds announced at its beginning, and what the arm did."""

    announced_s: float
    announced_mm: float
    time_s: float
    way_mm: float


class DriverProcess:
    """The program that drives the arm (`driver_program`), in a process of its own."""

    def __init__(self, port: str, dialect: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.driver_program", port, dialect],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self.read_reply()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        with contextlib.suppress(BrokenPipeError):
            self._process.communicate(timeout=30.0)  # closing its input ends the program

    def ask(self, *words: object) -> Any:
        """Send a command, and return its result."""
        self.send(*words)
        return self.read_reply()

    def send(self, *words: object) -> None:
        """Send a command."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(words) + "\n")

    def kill(self) -> None:
        """Kill the program, so that it cannot stop the arm."""
        self._process.kill()
        self._process.wait()

    def suspend(self) -> None:
        """Suspend the program, as Ctrl-Z does."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Resume the program."""
        self._process.send_signal(signal.SIGCONT)

    def read_reply(self) -> Any:
        """Wait for the result of a command that was sent, and return it."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError("the driving program has ended")
        return json.loads(line)


@dataclass(frozen=True, slots=True)
class Ending:
    """One way to end a motion: how the motion begins, what ends it, and which bounds hold.

    `silent`: the bounds of a silent program hold, else those of a stop.
    """

    what: str
    begin: str
    end: Callable[[DriverProcess], None]
    silent: bool = False


ENDINGS = (
    Ending("a jog is released", "jog", lambda host: host.send("release")),
    Ending("a motion is stopped", "move", lambda host: host.send("stop")),
    Ending("the program is killed in a jog", "jog", DriverProcess.kill, silent=True),
    Ending("the program is killed in a motion", "move", DriverProcess.kill, silent=True),
)


def measure(dialect: str, ending: Ending, times: int) -> list[StopMeasurement]:
    """Measure one way to end a motion several times."""
    chance = random.Random(f"{SEED} {dialect} {ending.what}")
    host: DriverProcess | None = None
    found = []
    with PtyBench(dialect) as bench:
        try:
            for index in range(times):
                host = host or DriverProcess(bench.port, dialect)
                after_s = chance.uniform(*MOMENTS_S)
                found.append(measure_once(bench, host, ending, (-1.0) ** index, after_s))
                if ending.silent:
                    host.__exit__()
                    host = None
        finally:
            if host is not None:
                host.__exit__()
    return found


def measure_once(
    bench: ProcessBench, host: DriverProcess, ending: Ending, direction: float, after_s: float
) -> StopMeasurement:
    """Begin a motion, end it, and watch until the physical arm stands."""
    start = bench.look()
    host.ask("reference", list(start.motors))
    host.ask(ending.begin, direction)
    bench.wait_until_moving()
    bench.sleep(after_s)
    bounds = host.ask("bounds")
    seen: Observation = bench.look()
    ending.end(host)
    rest = bench.rest(seen)
    if not ending.silent:
        host.read_reply()
        while host.ask("state") != "standby":
            bench.sleep(bench.look_s)
    time_s, way_mm = bounds[2:] if ending.silent else bounds[:2]
    return StopMeasurement(time_s, way_mm, rest.after_s, rest.way_mm)
