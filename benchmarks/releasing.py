"""Print how long an arm goes on when a jog key is let go: `python benchmarks/releasing.py`.

A keyboard of 11, 25 or 33 repeats a second, on a link with 60 ms of jitter, holds a key of the desk
for 1 to 2 s; then the same on a link that stalls for a second and delivers everything at once. Time
and way are those of the physical arm from the moment the finger lifts. The bound is what the
status announces at that moment, after the link's jitter and the dead-man's longest patience; in
mm, the announced distance in proportion.

An increment is bounded by its own distance, and goes on to its end whoever lets go. So presses
stand in rows of their own whose first increment was still under way, and those of which a stall
left a single repeat, which is a tap to whoever sees it alone.

The desk works without its screen here, on simulated time: the same in every run. The whole desk in
real time is in desk.py and desk_ends.py. Exit code 1 where a bound is broken.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from feel import Figures, Measured, Options, report
from feel_benches import DenseMemoryBench, chance
from feel_desk import MIDDLE, SimulatedDesk, choose, increments, set_up
from feel_keys import JITTER_S, RATES_HZ, Press, press

from armdrive.arm import Arm
from armdrive.motion.dead_man import HOLD_LONGEST_S
from kinematics import Joints
from tests.conformance.bench import Bench
from tests.conformance.observation import Observation

TIMES, QUICK_TIMES = 1000, 5
QUIET_S = 0.6
SELDOM_S = 0.02
NOTHING_COMES_S = 0.4
"""After the last event, the dead-man has nothing under way any more."""
PATIENCE_S = JITTER_S + HOLD_LONGEST_S


@dataclass(frozen=True, slots=True)
class Released:
    """One press: how long and how far the arm went on after it, and what had been announced."""

    time: Measured
    way: Measured
    tapped: bool
    moved: bool
    """Whether the arm was still moving when the finger lifted, or moved after it."""


@dataclass(frozen=True, slots=True)
class Promise:
    """What a driver announces at the moment at which the finger lifts."""

    stop_s: float
    stop_mm: float
    asked_s: float
    """Of `stop_s`, what the motion lasts that was asked for already."""
    increment_mm: float
    """How far the tip goes in an increment at most."""
    stepping: bool
    """Whether an increment is under way."""


def promised(arm: Arm) -> Promise:
    """Return what an arm of this process announces now."""
    status = arm.status
    return Promise(
        status.stop_time_s,
        status.stop_distance_mm,
        arm.parts.core.controller.stopping(arm.config.motion.jog_burst_s).asked_motion_s,
        math.radians(2.0) * max(arm.model.arm.levers_mm(arm.joints)),
        increments.under_way,
    )


class Seeing:
    """Looks at the physical arm from when the finger lifts, and says what it did from then on."""

    def __init__(self, bench: Bench) -> None:
        self._first = self._last = self._moved = bench.look()
        self._step_mm = bench.step_mm(self._first.motors)
        self._way_mm = 0.0

    def take(self, seen: Observation) -> None:
        """Take in a look."""
        self._way_mm = max(self._way_mm, seen.off_mm(self._first))
        if seen.motors != self._moved.motors:
            self._moved = seen
        self._last = seen

    @property
    def quiet(self) -> bool:
        """Whether the arm has stood for a while."""
        return self._last.time_s - self._moved.time_s >= QUIET_S

    def every_s(self, look_s: float) -> float:
        """Return when to look next: seldom at an arm that stands."""
        return look_s if self._last.time_s - self._moved.time_s < 2.0 * SELDOM_S else SELDOM_S

    def released(self, promise: Promise, *, tapped: bool) -> Released:
        """Return what it came to; of an increment nothing is promised but its distance."""
        tapped = tapped or promise.stepping
        patient_mm = promise.stop_mm * (1.0 + PATIENCE_S / promise.asked_s) + self._step_mm
        time_s = self._moved.time_s - self._first.time_s
        bound_s = PATIENCE_S + promise.stop_s
        return Released(
            Measured(time_s * 1e3, math.inf if tapped else bound_s * 1e3),
            Measured(self._way_mm, patient_mm + promise.increment_mm * tapped),
            tapped,
            self._way_mm > 0.0,
        )


class Hand:
    """Presses keys of a desk."""

    def __init__(self, bench: DenseMemoryBench, arm: Arm, home: Joints, luck: Random) -> None:
        self._bench, self._arm, self._home, self._luck = bench, arm, home, luck

    def press(self, way: Press) -> Released:
        """Hold a key of a new desk, and watch what the arm does after it."""
        desk = SimulatedDesk(self._arm)
        set_up(desk)
        desk.hand.arm_keys()
        self._bench.sleep(NOTHING_COMES_S)
        key = choose(desk, self._arm, self._home, self._luck)
        start_s = self._arm.parts.pace.now_s()
        lifted_s = start_s + way.lifted_s
        seeing: Seeing | None = None
        for arrival_s in (*way.arrivals_s, math.inf):
            due_s = start_s + arrival_s
            if seeing is None and due_s > lifted_s:
                self._until(desk, lifted_s)
                promise, seeing = promised(self._arm), Seeing(self._bench)
            if math.isfinite(due_s):
                self._until(desk, due_s, seeing)
                desk.hand.press(key)
        assert seeing is not None
        self._until(desk, max(lifted_s, start_s + way.arrivals_s[-1]) + NOTHING_COMES_S, seeing)
        while not seeing.quiet:
            self._until(desk, self._arm.parts.pace.now_s() + SELDOM_S, seeing)
        return seeing.released(promise, tapped=desk.tapped_s > lifted_s)

    def _until(self, desk: SimulatedDesk, time_s: float, seeing: Seeing | None = None) -> None:
        """Let time pass; the desk's timer rings when it is due, and the arm is looked at."""
        pace = self._arm.parts.pace
        while (now_s := pace.now_s()) < time_s:
            look_s = math.inf if seeing is None else now_s + seeing.every_s(self._bench.look_s)
            self._arm.sleep(min(desk.deadline.due_s, look_s, time_s) - now_s)
            if pace.now_s() >= desk.deadline.due_s:
                desk.hand.tick()
            if seeing is not None:
                seeing.take(self._bench.look())


def at_home(bench: DenseMemoryBench) -> tuple[Arm, Joints]:
    """Connect, and bring the arm to the middle of where it will be jogged."""
    arm = bench.ready()
    arm.move_j(MIDDLE)
    return arm, arm.joints


def kinds() -> Iterator[tuple[str, float, bool]]:
    """Give each keyboard, without and with the stall."""
    for stalls in (False, True):
        for rate_hz in RATES_HZ:
            words = ", the link stalls" if stalls else ""
            yield f"{rate_hz} Hz, {JITTER_S * 1e3:.0f} ms of jitter{words}", rate_hz, stalls


def figures(dialect: str, what: str, found: list[Released]) -> Iterator[Figures]:
    """Give time and way; those that ended in a tap by themselves."""
    for words, those in (
        (what, [each for each in found if not each.tapped]),
        (f"{what}: an increment", [each for each in found if each.tapped]),
    ):
        if those:
            yield Figures(dialect, words, "ms", [each.time for each in those])
            yield Figures(dialect, words, "mm", [each.way for each in those])


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """Press so many keys of each kind on one dialect."""
    with DenseMemoryBench(dialect) as bench:
        arm, home = at_home(bench)
        for what, rate_hz, stalls in kinds():
            luck = chance(dialect, what)
            hand = Hand(bench, arm, home, luck)
            found = [hand.press(press(luck, rate_hz, stalls=stalls)) for _ in range(options.times)]
            yield from figures(dialect, what, found)


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(
        argv, __doc__, measure, times=TIMES, quick_times=QUICK_TIMES, clocks=("simulated",)
    )


if __name__ == "__main__":
    sys.exit(main())
