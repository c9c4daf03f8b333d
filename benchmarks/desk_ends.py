"""Print how long an arm goes on when its desk ends in mid-jog: `python benchmarks/desk_ends.py`.

The whole desk on a pseudo-terminal, jogged at full speed by a key that repeats 30 times a second,
and its arm a twin in another process. The desk is killed outright, its terminal is closed, with and
without its end being told, or it is suspended while the keys go on. Time and way are those of the
physical arm, from the end on; the bound is what the status announced just before. A desk that was
suspended goes on after a while: what has been typed meanwhile may not move the arm.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from desk_terminal import LinedTerminal, desk_of
from feel import Figures, Measured, Options, report
from feel_benches import DensePtyBench, chance

TIMES, QUICK_TIMES = 5, 1
REPEAT_S = 1.0 / 30.0
DELAY_S = 0.3
MOMENTS_S = (0.3, 0.9)
"""The arm has moved for so long when the desk ends."""

ASLEEP_S = 0.5
"""And as long as it takes to see that an arm stands: longer than a pause of its own computer may
last for the driver."""

WOKEN_S = 1.5
PATIENCE_S = 10.0
KEYS = (b"q", b"a")
"""The base, there and back."""


class Finger:
    """Holds a key from now on, as a keyboard does, until it lifts."""

    def __init__(self, desk: LinedTerminal, key: bytes) -> None:
        self._desk, self._key = desk, key
        self._lifted = threading.Event()
        self._thread = threading.Thread(target=self._hold, daemon=True)
        self._thread.start()

    def _hold(self) -> None:
        self._desk.type(self._key)
        due_s = time.monotonic() + DELAY_S
        while not self._lifted.wait(max(due_s - time.monotonic(), 0.0)):
            with contextlib.suppress(OSError):  # nobody reads what is typed any more
                self._desk.type(self._key)
            due_s += REPEAT_S

    def lift(self) -> None:
        """Let go."""
        self._lifted.set()
        self._thread.join()


@contextlib.contextmanager
def held(desk: LinedTerminal, key: bytes) -> Iterator[Finger]:
    """Hold a key meanwhile."""
    finger = Finger(desk, key)
    try:
        yield finger
    finally:
        finger.lift()


@dataclass(frozen=True, slots=True)
class End:
    """One way to end: what is done, with what code the desk ends; None where it goes on."""

    what: str
    do: Callable[[LinedTerminal, Finger], None]
    code: int | None
    stops: bool
    """Whether the desk still has a word in it: then the greater of both bounds holds."""


def _signalled(number: int) -> Callable[[LinedTerminal, Finger], None]:
    return lambda desk, _: desk.process.send_signal(number)


def _closed(desk: LinedTerminal, finger: Finger) -> None:
    finger.lift()  # a terminal that is gone has no keys
    desk.close()


ENDS = (
    End("killed (SIGKILL)", _signalled(signal.SIGKILL), -signal.SIGKILL, stops=False),
    End("told that its terminal is gone (SIGHUP)", _signalled(signal.SIGHUP), 129, stops=True),
    End("its terminal is closed", _closed, 129, stops=True),
    End("suspended (SIGSTOP)", _signalled(signal.SIGSTOP), None, stops=False),
)


@dataclass(frozen=True, slots=True)
class Ended:
    """What one end came to."""

    time: Measured
    way: Measured
    code: int
    after_mm: Measured | None
    """How far the tip went after the desk went on."""


def end_once(bench: DensePtyBench, end: End, key: bytes, moved_s: float) -> Ended:
    """Jog from a new desk, end it, and watch."""
    with desk_of(bench.port, bench.row.name, bench.look().motors) as desk:
        desk.arm_keys()
        with held(desk, key) as finger:
            bench.wait_until_moving()
            bench.sleep(moved_s)
            said = desk.ask("look")
            *_, seen = bench.watch(lambda: bench.turning, PATIENCE_S)
            end.do(desk, finger)
            rest = bench.rest(seen)
        after_mm = _wake(bench, desk) if end.code is None else None
        code = desk.end() if end.code is None else desk.process.wait(PATIENCE_S)
    step_mm = bench.step_mm(seen.motors)
    time_s, way_mm = said["silent_s"], said["silent_mm"]
    if end.stops:
        time_s, way_mm = max(time_s, said["stop_s"]), max(way_mm, said["stop_mm"])
    return Ended(
        Measured(rest.after_s * 1e3, time_s * 1e3),
        Measured(rest.way_mm, way_mm + step_mm),
        code,
        after_mm,
    )


def _wake(bench: DensePtyBench, desk: LinedTerminal) -> Measured:
    """Let a suspended desk go on, and return how far the tip goes then; nowhere, it is hoped."""
    bench.sleep(ASLEEP_S)
    stood = bench.look()
    desk.process.send_signal(signal.SIGCONT)
    end_s = stood.time_s + WOKEN_S
    looks = bench.watch(lambda: bench.look().time_s > end_s, WOKEN_S * PATIENCE_S)
    return Measured(max(each.off_mm(stood) for each in looks), bench.step_mm(stood.motors))


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """End the desk of one dialect in every way."""
    with DensePtyBench(dialect) as bench:
        for end in ENDS:
            luck = chance("desk ends", dialect, end.what)
            found = [
                end_once(bench, end, KEYS[index % 2], luck.uniform(*MOMENTS_S))
                for index in range(options.times)
            ]
            yield Figures(dialect, end.what, "ms", [each.time for each in found])
            yield Figures(dialect, end.what, "mm", [each.way for each in found])
            if end.code is not None:
                wrong = sum(each.code != end.code for each in found)
                what = f"  ended with another code than {end.code}"
                yield Figures(dialect, what, "", [Measured(wrong, 0.0)])
            woken = [each.after_mm for each in found if each.after_mm is not None]
            if woken:
                yield Figures(dialect, "  and woken: the tip moves by", "mm", woken)


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(argv, __doc__, measure, times=TIMES, quick_times=QUICK_TIMES)


if __name__ == "__main__":
    sys.exit(main())
