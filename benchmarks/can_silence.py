"""Print what drives on a bus do when their host falls silent: `python benchmarks/can_silence.py`.

    python benchmarks/can_silence.py [mks | cia402 | cyclic ...] [--times N] [--quick] [--json]

In real time: six drives in one process, behind a serial CAN adapter on a pty; the program that
drives them in another, which is killed (SIGKILL) or suspended (SIGSTOP) in mid-path, in a joint
motion and in a jog. MKS drives have their watchdog off, at its default, and shorter than what is
sent ahead; CiA 402 drives watch their host's heartbeat for its default time and a shorter one, and
stand at their last target when no more come, or run on past it. Measured is until the physical
arm is seen to stand, until it was last seen to move (a busy computer looks seldom: the truth lies
between), and how far the tip came; beside it what the status announced (`silent_time_s`,
`silent_distance_mm`). A program that was suspended is then let go on: nothing may move; nor may it
where CiA 402 drives have stopped by themselves, although it was away for less than an absence. Exit
code 1 where a bound is broken.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from can_strategies import STRATEGIES, groups, measured
from feel import Figures, Measured, Options, report
from feel_benches import DensePtyBench, chance
from overrun import DriverProcess, Ending, measure_once

from tests.conformance.observation import Observation

TIMES, QUICK_TIMES = 5, 1
MOMENTS_S = (0.15, 0.6)
ASLEEP_S = 0.6
"""Beyond the time in which the arm comes to rest: so long is no pause, but an absence."""
WOKEN_S = 1.0
"""For so long an arm is looked at whose program has woken."""
PATIENCE_S = 10.0
BEGINNINGS = {"path": "a path", "move": "a joint motion", "jog": "a jog"}


@dataclass(frozen=True, slots=True)
class Guard:
    """How drives guard against silence: what an arm file says of it, and what drives are like.

    `drives` are lines of their section, `motion` of the section of that name; `habits` are settings
    of the simulated drives.
    """

    what: str
    drives: str = ""
    motion: str = ""
    habits: tuple[str, ...] = ()


SHORTER = "heartbeat_timeout_ms = 100\nheartbeat_period_ms = 25\n"
RUN_ON = ("hold_after_loss=extrapolate",)

GUARDS: dict[str, tuple[Guard, ...]] = {
    "steered": (
        Guard("watchdog 0.5 s"),
        Guard("no watchdog", "watchdog_s = 0.0\n"),
        Guard("watchdog 0.2 s", "watchdog_s = 0.2\n"),
        Guard("1 s ahead, watchdog 0.3 s", "watchdog_s = 0.3\n", "planned_burst_s = 1.0\n"),
    ),
    "together": (
        Guard("no watchdog", "watchdog_s = 0.0\n"),
        Guard("1 s ahead, watchdog 0.3 s", "watchdog_s = 0.3\n", "planned_burst_s = 1.0\n"),
    ),
    "in turn": (Guard("no watchdog"),),
    "cyclic": (
        Guard("heartbeat 200 ms"),
        Guard("heartbeat 100 ms", SHORTER),
        Guard("200 ms, drives run on", habits=RUN_ON),
        Guard("100 ms, drives run on", SHORTER, habits=RUN_ON),
    ),
    "profile": (
        Guard("heartbeat 200 ms"),
        Guard("1 s ahead, heartbeat 200 ms", "", "planned_burst_s = 1.0\n"),
    ),
}


@dataclass(frozen=True, slots=True)
class Silence:
    """One way to fall silent."""

    what: str
    begin: Callable[[DriverProcess], None]
    wakes: bool = True
    asleep_s: float = 0.0
    """For so long; else until the arm has come to rest, and longer."""


_LONG = (
    Silence("killed in", DriverProcess.kill, wakes=False),
    Silence("suspended in", DriverProcess.suspend),
)
SILENCES: dict[str, tuple[Silence, ...]] = {
    "mks": _LONG,
    "cia402": (*_LONG, Silence("suspended 0.5 s in", DriverProcess.suspend, asleep_s=0.5)),
}
"""Half a second is beyond what drives wait for their host's heartbeat, and below an absence."""


class LookingBench(DensePtyBench):
    """Remembers its looks: a computer that is busy elsewhere sees a stop later than it was."""

    def __init__(self, dialect: str) -> None:
        self._seen: list[Observation] = []
        super().__init__(dialect)

    def begin(self) -> None:
        """Forget what was seen before."""
        self._seen = [super().look()]

    def look(self) -> Observation:
        """Look, and remember it."""
        seen = super().look()
        self._seen.append(seen)
        return seen

    def moved_s(self) -> float:
        """Return until when it is certain that the arm had not come to its last place yet."""
        first = self._seen[0].time_s
        return max((each.time_s for each in self._elsewhere()), default=first) - first

    def stood_s(self) -> float:
        """Return from when on it was seen at its last place."""
        *_, first = itertools.takewhile(self._is_last, reversed(self._seen))
        return first.time_s - self._seen[0].time_s

    def after_mm(self, stood: Observation) -> float:
        """Return how far the tip has been from a place since it was seen there."""
        return max(each.off_mm(stood) for each in self._seen if each.time_s >= stood.time_s)

    def _elsewhere(self) -> list[Observation]:
        return [each for each in self._seen if not self._is_last(each)]

    def _is_last(self, seen: Observation) -> bool:
        return seen.motors == self._seen[-1].motors


class Ground:
    """A bench, and the program that drives it for as long as it lives."""

    def __init__(self, bench: LookingBench) -> None:
        self._bench = bench
        self._dialect = bench.row.name
        self._host: DriverProcess | None = None
        self.times: list[Measured] = []
        self.ways: list[Measured] = []
        self.after_waking: list[Measured] = []
        self.certain: list[Measured] = []
        """The times, less what passed between the last look in motion and the first at rest."""
        self._stood = bench.look()
        """Where the arm was when its program woke."""

    def fall_silent(self, silence: Silence, begin: str, after_s: float, direction: float) -> None:
        """Begin a motion, have its program fall silent, and watch the arm come to rest."""
        bench, host = self._bench, self._host or DriverProcess(self._bench.port, self._dialect)
        self._host = host
        ending = Ending(
            silence.what, begin, lambda each: self._silenced(silence, each), silent=True
        )
        host.ask("reference", list(bench.look().motors))
        host.ask("middle")
        found = measure_once(bench, host, ending, direction, after_s)
        bound_ms = found.announced_s * 1e3
        self.times.append(Measured(bench.stood_s() * 1e3, bound_ms))
        self.certain.append(Measured(bench.moved_s() * 1e3, bound_ms))
        self.ways.append(Measured(found.way_mm, found.announced_mm))
        if not silence.wakes:
            self.close()
            return
        if not silence.asleep_s:
            bench.sleep(ASLEEP_S)
            self._wake(host)
        self._woken(host)

    def _silenced(self, silence: Silence, host: DriverProcess) -> None:
        """Have the program fall silent, and remember what is seen from then on."""
        bench = self._bench
        bench.begin()
        silence.begin(host)
        if silence.asleep_s:
            end_s = bench.look().time_s + silence.asleep_s
            bench.wait_until(lambda: bench.look().time_s > end_s, PATIENCE_S)
            self._wake(host)

    def _wake(self, host: DriverProcess) -> None:
        self._stood = self._bench.look()
        host.resume()

    def _woken(self, host: DriverProcess) -> None:
        """Watch what an arm does whose program has woken, until that knows it too."""
        bench, stood = self._bench, self._stood
        end_s = stood.time_s + WOKEN_S
        bench.wait_until(lambda: bench.look().time_s > end_s, WOKEN_S * 10.0)
        self.after_waking.append(Measured(bench.after_mm(stood), bench.step_mm(stood.motors)))
        end_s = time.monotonic() + PATIENCE_S
        while (state := host.ask("state")) not in ("standby", "error-stop"):
            if time.monotonic() > end_s:
                raise TimeoutError(f"a program that woke is still {state}")
            bench.sleep(bench.look_s)

    def close(self) -> None:
        """End the program."""
        if self._host is not None:
            self._host.resume()
            self._host.__exit__()
            self._host = None


def measure(options: Options, strategy: str) -> Iterator[Figures]:
    """Fall silent in every way, under every guard of a strategy."""
    how = STRATEGIES[strategy]
    for guard in GUARDS[strategy]:
        lines = measured(how.dialect) + how.section(guard.drives)
        if guard.motion:
            lines += f"[motion]\n{guard.motion}"
        with LookingBench(how.dialect) as bench:
            bench.use_arm_file(lines, *guard.habits)
            for silence in SILENCES[how.dialect]:
                yield from silenced(bench, strategy, guard, silence, options.times)


def silenced(
    bench: LookingBench, strategy: str, guard: Guard, silence: Silence, times: int
) -> Iterator[Figures]:
    """Fall silent in one way, in each kind of motion."""
    for begin, named in BEGINNINGS.items():
        ground, luck = Ground(bench), chance(strategy, guard.what, silence.what, begin)
        try:
            for _ in range(times):
                ground.fall_silent(
                    silence, begin, luck.uniform(*MOMENTS_S), luck.choice((-1.0, 1.0))
                )
        finally:
            ground.close()
        what = f"{guard.what}: {silence.what} {named}"
        yield Figures(strategy, what, "ms", ground.times)
        yield Figures(strategy, "  until it was last seen to move", "ms", ground.certain)
        yield Figures(strategy, what, "mm", ground.ways)
        if silence.wakes:
            yield Figures(strategy, "  and woken: the tip moves by", "mm", ground.after_waking)


def main(argv: list[str] | None = None) -> int:
    """Measure every strategy, or those that are asked for."""
    return report(
        argv,
        __doc__,
        measure,
        dialects=STRATEGIES,
        times=TIMES,
        quick_times=QUICK_TIMES,
        groups=groups(STRATEGIES),
    )


if __name__ == "__main__":
    sys.exit(main())
