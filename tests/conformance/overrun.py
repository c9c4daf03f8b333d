"""How long and how far the physical arm goes on, in real time, beside what was announced.

The arm is a twin in another process, over a pty; the program that drives it is a third process,
which lets go of a jog, stops a motion, or is killed outright.
"""

from __future__ import annotations

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

from .real_time_bench import ProcessBench, PtyBench
from .seen import Seen

ROOT = Path(__file__).parents[2]
SEED = 1982
MOMENTS_S = (0.15, 0.6)
"""The arm moves for so long, drawn anew each time, before it is to end."""

LOOK_S = PtyBench.look_s
"""The resolution of what is measured."""


@dataclass(frozen=True, slots=True)
class Overrun:
    """One time: what was announced when it was asked for, and what came."""

    announced_s: float
    announced_mm: float
    time_s: float
    way_mm: float

    @property
    def kept(self) -> bool:
        """Whether the promise was kept."""
        return self.time_s <= self.announced_s and self.way_mm <= self.announced_mm


class Host:
    """The program that drives, in a process of its own."""

    def __init__(self, port: str, dialect: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.conformance.host", port, dialect],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self.answered()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        with contextlib.suppress(BrokenPipeError):
            self._process.communicate(timeout=30.0)  # the end of its input ends it

    def ask(self, *words: object) -> Any:
        """Give a command and wait for its answer."""
        self.tell(*words)
        return self.answered()

    def tell(self, *words: object) -> None:
        """Give a command."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(words) + "\n")

    def kill(self) -> None:
        """End the program without a chance to say anything."""
        self._process.kill()
        self._process.wait()

    def suspend(self) -> None:
        """Have the program stand still in whatever it is doing, as by Ctrl-Z."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Let it go on."""
        self._process.send_signal(signal.SIGCONT)

    def answered(self) -> Any:
        """Wait for the answer to a command that was told."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError("the driving program has ended")
        return json.loads(line)


@dataclass(frozen=True, slots=True)
class Ending:
    """One way to end a motion: how it begins, what ends it, which pair of bounds holds for it."""

    what: str
    begin: str
    end: Callable[[Host], None]
    silent: bool = False


ENDINGS = (
    Ending("a jog is released", "jog", lambda host: host.tell("release")),
    Ending("a motion is stopped", "move", lambda host: host.tell("stop")),
    Ending("the program is killed in a jog", "jog", Host.kill, silent=True),
    Ending("the program is killed in a motion", "move", Host.kill, silent=True),
)


def measure(dialect: str, ending: Ending, times: int) -> list[Overrun]:
    """Measure one way to end a motion, several times."""
    chance = random.Random(f"{SEED} {dialect} {ending.what}")
    host: Host | None = None
    found = []
    with PtyBench(dialect) as bench:
        try:
            for index in range(times):
                host = host or Host(bench.port, dialect)
                after_s = chance.uniform(*MOMENTS_S)
                found.append(once(bench, host, ending, (-1.0) ** index, after_s))
                if ending.silent:
                    host.__exit__()
                    host = None
        finally:
            if host is not None:
                host.__exit__()
    return found


def once(
    bench: ProcessBench, host: Host, ending: Ending, direction: float, after_s: float
) -> Overrun:
    """Move, end it, and watch the physical arm come to rest."""
    start = bench.look()
    host.ask("refer", list(start.motors))
    host.ask(ending.begin, direction)
    for _ in bench.watch(lambda: bench.look().motors != start.motors, 10.0):
        pass
    bench.sleep(after_s)
    bounds = host.ask("bounds")
    seen: Seen = bench.look()
    ending.end(host)
    rest = bench.rest(seen)
    if not ending.silent:
        host.answered()
        while host.ask("state") != "standby":
            bench.sleep(bench.look_s)
    time_s, way_mm = bounds[2:] if ending.silent else bounds[:2]
    return Overrun(time_s, way_mm, rest.after_s, rest.way_mm)
