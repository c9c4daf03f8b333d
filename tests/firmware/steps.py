"""Step times: from the step log of a simulated processor, or by sampling positions."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from kinematics import Motors
from tests.conformance.bench import Bench
from tests.conformance.observation import Observation


@dataclass(frozen=True, slots=True)
class Step:
    """One step of one motor, by the device's clock."""

    time_s: float
    axis: str
    direction: int


@runtime_checkable
class LogsSteps(Protocol):
    """A bench that logs the time of every step."""

    def device_now_s(self) -> float:
        """Return the time by the clock of the step log."""

    def steps_since(self, time_s: float) -> list[Step]:
        """Return the steps after a time."""


class StepLog:
    """The step log that the processor simulator writes."""

    def __init__(self, path: Path, hz: int) -> None:
        self.path, self._hz = path, hz

    def since(self, time_s: float) -> list[Step]:
        """Return the steps after a time."""
        with self.path.open(encoding="ascii") as lines:
            next(lines)
            return [step for line in lines if (step := self._step(line)).time_s > time_s]

    def _step(self, line: str) -> Step:
        cycle, axis, direction, _ = line.split(",")
        return Step(int(cycle) / self._hz, axis, int(direction))


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion as it was observed. Times are in seconds from the start of watching.

    `first_s` and `last_s` are the times of the first and the last step; `pulses` is the number of
    steps of the motor that made most.
    """

    first_s: float
    last_s: float
    pulses: int
    way_mm: float
    end: Observation

    @property
    def physical_s(self) -> float:
        """The time from the first step to the last."""
        return self.last_s - self.first_s


class Watcher:
    """Observes a bench from its creation on."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._start = bench.look()
        self._log = bench if isinstance(bench, LogsSteps) else None
        self._log_start_s = self._log.device_now_s() if self._log else 0.0

    def until(self, done: Callable[[], bool], longest_s: float) -> Motion:
        """Observe until `done()` and until the arm stands."""
        seen = list(self._bench.watch(done, longest_s))
        seen.append(self._bench.rest(longest_s=longest_s).end)
        way_mm = max(each.off_mm(self._start) for each in seen)
        if self._log is not None:
            first_s, last_s, pulses = self._by_log()
        else:
            first_s, last_s, pulses = self._by_looks(seen)
        return Motion(first_s, last_s, pulses, way_mm, seen[-1])

    def _by_log(self) -> tuple[float, float, int]:
        assert self._log is not None
        steps = self._log.steps_since(self._log_start_s)
        if not steps:
            return 0.0, 0.0, 0
        counts = {
            axis: sum(each.axis == axis for each in steps) for axis in {s.axis for s in steps}
        }
        first_s, last_s = steps[0].time_s, steps[-1].time_s
        return first_s - self._log_start_s, last_s - self._log_start_s, max(counts.values())

    def _by_looks(self, seen: list[Observation]) -> tuple[float, float, int]:
        times, before = [], self._start
        pulses = Motors([0] * len(before.motors))
        for each in seen:
            if each.motors != before.motors:
                times.append(each.time_s - self._start.time_s)
                made = each.motors - before.motors
                pulses = Motors(abs(a) + b for a, b in zip(made, pulses, strict=True))
            before = each
        return (times[0], times[-1], pulses.largest) if times else (0.0, 0.0, 0)
