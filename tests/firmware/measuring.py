"""How soon an arm's motions stop."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from armdrive.arm import Arm
from armdrive.errors import ArmError
from armdrive.moves import Jog
from armdrive.status import State, Trust
from kinematics import Motors
from tests.conformance.bench import Bench
from tests.conformance.observation import Broken, Observation, check
from tests.conformance.rows_moving import check_arrived


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


LONG_DEG = 60.0

RATES_HZ = (25.0, 50.0, 100.0, 400.0)
TRIES = 3
STEADY_S = 1.0
"""How long a motion runs before it is stopped, so that every buffer is full."""
UNEVEN_S = 0.037
"""Each try is stopped this much later, to vary the state of the buffers."""
HOLD_S, RENEWALS = 0.8, 5
STANDS_S = 10.0


def _back(bench: Bench, arm: Arm, home: dict[str, float]) -> Arm:
    """Recover from the last motion if necessary, and return to the start posture."""
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    if arm.status.state is State.DISCONNECTED:
        arm = bench.connect()
    if arm.status.trust is not Trust.REFERENCED:
        bench.reference(arm)
    arm.move_j(**home)
    return arm


# -- An arm with its driver ---------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Stopped:
    """One stop: the announced bounds and the result.

    `rate_hz` is the rate that was asked for, and `actual_hz` the rate before the stop. `pulses`
    counts the steps of the quickest motor after it.
    """

    how: str
    rate_hz: float
    actual_hz: float
    announced_s: float
    took_s: float
    announced_mm: float
    way_mm: float
    pulses: int
    wrong: str = ""

    @property
    def within(self) -> bool:
        """Whether the arm stood within the announced bounds."""
        return self.took_s <= self.announced_s and self.way_mm <= self.announced_mm

    @property
    def kept(self) -> bool:
        """Whether the arm also knows its position."""
        return not self.wrong and self.within


def stops(bench: Bench, rates_hz: tuple[float, ...] = RATES_HZ) -> Iterator[Stopped]:
    """Stop a motion and release a jog at every rate that the arm's first joint reaches."""
    arm = bench.ready()
    home = {f"{name}_deg": angle for name, angle in arm.joints.deg.items()}
    for how in ("stop", "release"):
        for rate_hz in (each for each in rates_hz if each <= full_rate_hz(bench)):
            for number in range(TRIES if bench.real_time else 1):
                try:
                    yield _stopped(bench, arm, how, rate_hz, STEADY_S + number * UNEVEN_S)
                except (ArmError, Broken) as error:
                    bench.rest()
                    yield Stopped(how, rate_hz, 0.0, 0.0, 0.0, 0.0, 0.0, 0, _words(error))
                arm = _back(bench, arm, home)


def full_rate_hz(bench: Bench) -> float:
    """Return the step rate of the first joint's motor at full speed."""
    return abs(bench.transmission.matrix[0][0]) * bench.config.model.joint_speeds_rad_s[0]


def _stopped(bench: Bench, arm: Arm, how: str, rate_hz: float, after_s: float) -> Stopped:
    """Move the first joint at a rate, and end that after some time."""
    speed = rate_hz / full_rate_hz(bench)
    jog = Jog.joint(**{arm.model.arm.joint_names[0]: 1.0})

    def keep_moving() -> None:
        if how == "release":
            arm.jogging.hold(jog, speed=speed, for_s=HOLD_S)

    if how == "stop":
        first = arm.model.arm.joint_names[0]
        arm.move_j(wait=False, speed=speed, **{f"{first}_deg": arm.joints.deg[first] + LONG_DEG})
    keep_moving()
    bench.wait_until_moving()
    before = bench.look()
    for _ in range(RENEWALS):
        keep_moving()
        bench.sleep(after_s / RENEWALS)
    seen = bench.look()
    actual_hz = seen.off_steps(before.motors) / (seen.time_s - before.time_s)
    status = arm.status
    told = f"in {status.state.value}, and was to be stopped in motion: {status.error}"
    check(status.state is State.MOVING, told)
    watcher = Watcher(bench)
    if how == "stop":
        arm.request_stop()
    else:
        arm.jogging.release()
    motion = watcher.until(lambda: arm.status.state is not State.MOVING, STANDS_S)
    return Stopped(
        how,
        rate_hz,
        actual_hz,
        status.stop_time_s,
        motion.last_s,
        status.stop_distance_mm,
        motion.way_mm,
        motion.pulses,
        _settled(bench, arm),
    )


def _settled(bench: Bench, arm: Arm) -> str:
    """Return what is wrong with a stopped arm; empty if it knows where it stands."""
    try:
        bench.wait_until(lambda: arm.status.state is State.STANDBY, STANDS_S)
        check_arrived(bench, arm)
    except Broken as error:
        return f"{error} ({arm.status.error})" if arm.status.error else str(error)
    return ""


def _words(error: Exception) -> str:
    code = getattr(error, "code", "")
    return f"{code} {error}".strip() if code else str(error)
