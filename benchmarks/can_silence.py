"""Print what MKS drives do when their host falls silent: `python benchmarks/can_silence.py`.

In real time: six drives in one process, behind a serial CAN adapter on a pty; the program that
drives them in another, which is killed (SIGKILL) or suspended (SIGSTOP) in mid-path, in a joint
motion and in a jog; with the drives' watchdog off, at its default, and shorter than what is sent
ahead. Measured is until the physical arm is seen to stand, until it was last seen to move (a busy
computer looks seldom: the truth lies between), and how far the tip came; beside it what the status
announced (`silent_time_s`, `silent_distance_mm`). A program that was suspended is then let
go on: nothing may move. Exit code 1 where a bound is broken.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from can_strategies import DIALECT, MEASURED, STRATEGIES, section
from feel import Figures, Measured, Options, report
from feel_benches import DensePtyBench, chance

from tests.conformance.overrun import Ending, Host, once
from tests.conformance.seen import Seen

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
    """How the drives guard against silence: what an arm file says of it."""

    what: str
    mks: str = ""
    motion: str = ""


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
}


@dataclass(frozen=True, slots=True)
class Silence:
    """One way to fall silent."""

    what: str
    begin: Callable[[Host], None]
    wakes: bool


SILENCES = (
    Silence("killed in", Host.kill, wakes=False),
    Silence("suspended in", Host.suspend, wakes=True),
)


class LookingBench(DensePtyBench):
    """Remembers its looks: a computer that is busy elsewhere sees a stop later than it was."""

    def __init__(self, dialect: str) -> None:
        self._seen: list[Seen] = []
        super().__init__(dialect)

    def begin(self) -> None:
        """Forget what was seen before."""
        self._seen = [super().look()]

    def look(self) -> Seen:
        """Look, and remember it."""
        seen = super().look()
        self._seen.append(seen)
        return seen

    def moved_s(self) -> float:
        """Return until when it is certain that the arm had not come to its last place yet."""
        first, last = self._seen[0], self._seen[-1]
        elsewhere = [each.time_s for each in self._seen if each.motors != last.motors]
        return max(elsewhere, default=first.time_s) - first.time_s


class Ground:
    """A bench, and the program that drives it for as long as it lives."""

    def __init__(self, bench: LookingBench) -> None:
        self._bench = bench
        self._host: Host | None = None
        self.times: list[Measured] = []
        self.ways: list[Measured] = []
        self.after_waking: list[Measured] = []
        self.certain: list[Measured] = []
        """The times, less what passed between the last look in motion and the first at rest."""

    def fall_silent(self, silence: Silence, begin: str, after_s: float) -> None:
        """Begin a motion, have its program fall silent, and watch the arm come to rest."""
        bench, host = self._bench, self._host or Host(self._bench.port, DIALECT)
        self._host = host
        ending = Ending(
            silence.what, begin, lambda each: self._silenced(silence, each), silent=True
        )
        direction = -1.0 if bench.look().tip[1] > 0.0 else 1.0  # towards the middle
        found = once(bench, host, ending, direction, after_s)
        bound_ms = found.announced_s * 1e3
        self.times.append(Measured(found.time_s * 1e3, bound_ms))
        self.certain.append(Measured(bench.moved_s() * 1e3, bound_ms))
        self.ways.append(Measured(found.way_mm, found.announced_mm))
        if silence.wakes:
            self._wake(host)
        else:
            self.close()

    def _silenced(self, silence: Silence, host: Host) -> None:
        """Have the program fall silent, and remember what is seen from then on."""
        self._bench.begin()
        silence.begin(host)

    def _wake(self, host: Host) -> None:
        bench = self._bench
        bench.sleep(ASLEEP_S)
        stood = bench.look()
        host.resume()
        end_s = stood.time_s + WOKEN_S
        way_mm = 0.0
        for seen in bench.watch(lambda: bench.look().time_s > end_s, WOKEN_S * 10.0):
            way_mm = max(way_mm, seen.off_mm(stood))
        self.after_waking.append(Measured(way_mm, bench.step_mm(stood.motors)))
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
    for guard in GUARDS[strategy]:
        lines = MEASURED + section(strategy, guard.mks)
        if guard.motion:
            lines += f"[motion]\n{guard.motion}"
        with LookingBench(DIALECT) as bench:
            bench.fit(lines)
            for silence in SILENCES:
                yield from silenced(bench, strategy, guard, silence, options.times)


def silenced(
    bench: LookingBench, strategy: str, guard: Guard, silence: Silence, times: int
) -> Iterator[Figures]:
    """Fall silent in one way, in each kind of motion."""
    for begin, named in BEGINNINGS.items():
        ground, luck = Ground(bench), chance(strategy, guard.what, silence.what, begin)
        try:
            for _ in range(times):
                ground.fall_silent(silence, begin, luck.uniform(*MOMENTS_S))
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
    return report(argv, __doc__, measure, dialects=STRATEGIES, times=TIMES, quick_times=QUICK_TIMES)


if __name__ == "__main__":
    sys.exit(main())
