"""Print how far drives on a bus are from moving together: `python benchmarks/can_coordination.py`.

    python benchmarks/can_coordination.py [mks | cia402 | cyclic ...] [--times N] [--quick]

On simulated time, the drives' shafts are looked at every 4 ms. For each strategy: motions that are
straight in joint space, as far as the tip leaves that way and a joint its proportion; and lines and
arcs of every kind, as far as the tip leaves them. Promised are `motion.line_tolerance_mm`, what a
count of each drive is worth, and where the arm announces that its motors are not coordinated,
`deviation_mm` of the move. Beside them a plain program that coordinates nothing: each drive is sent
to its target at the same speed. Exit code 1 where a bound is broken.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from can_plain import PLAIN
from can_strategies import STRATEGIES, Strategy, groups
from feel import Figures, Measured, Options, report
from feel_benches import DENSE_S, DenseMemoryBench, chance
from feel_ways import KINDS, ways
from straightness import drawn

from armdrive.arm import Arm
from armdrive.errors import OutOfBounds
from kinematics import Joints, Motors
from tests.conformance.observation import Point, place
from tests.conformance.rows_moving import line_allowance_mm, off_line_mm

TIMES, QUICK_TIMES = 40, 1
PATIENCE_S = 60.0
TURN_DEG = (15.0, 45.0)
"""How far the joint that turns furthest goes."""
SLOWEST = 0.3
ALL: dict[str, Strategy] = {**STRATEGIES, **PLAIN}
LOOKS = 400
"""On the straight way, with which a place beside it is compared."""


@dataclass(frozen=True, slots=True)
class Beside:
    """How far a motion was from the straight way in joint space, at most."""

    tip_mm: float
    joint_deg: float


class StraightWay:
    """The way between two postures on which every joint turns in proportion."""

    def __init__(self, bench: DenseMemoryBench, start: Motors, end: Motors) -> None:
        self._bench = bench
        self._start, self._end = (bench.posture(each)[0] for each in (start, end))
        shares = [index / LOOKS for index in range(LOOKS + 1)]
        self._tips = [self._tip(self._at(share)) for share in shares]

    def beside(self, motors: Motors) -> Beside:
        """Return how far a place is from it: the tip from its line, joints from their share."""
        here = self._bench.posture(motors)[0]
        way = [b - a for a, b in zip(self._start, self._end, strict=True)]
        gone = [b - a for a, b in zip(self._start, here, strict=True)]
        square = math.fsum(each * each for each in way)
        share = math.fsum(a * b for a, b in zip(way, gone, strict=True)) / square
        off = max(abs(a - share * b) for a, b in zip(gone, way, strict=True))
        tip = self._bench.tip(motors)
        return Beside(self._off_mm(tip, min(max(share, 0.0), 1.0)), math.degrees(off))

    def _off_mm(self, tip: Point, share: float) -> float:
        """Return the distance from the nearest piece of the tip's way near a share."""
        middle = min(max(round(share * LOOKS), 1), LOOKS - 1)
        near = range(max(middle - LOOKS // 10, 0), min(middle + LOOKS // 10, LOOKS))
        return min(off_line_mm(tip, self._tips[i], self._tips[i + 1]) for i in near)

    def _at(self, share: float) -> Joints:
        ends = zip(self._start, self._end, strict=True)
        named = zip(self._start.names, (a + share * (b - a) for a, b in ends), strict=True)
        return self._start.replace(**dict(named))

    def _tip(self, joints: Joints) -> Point:
        return place(self._bench.config.model.arm.fk(joints))


def posture(arm: Arm, luck: Random) -> Joints:
    """Return a posture by chance over the table."""
    low = {"base": -60.0, "shoulder": 30.0, "elbow": -100.0, "wrist_pitch": -60.0}
    high = {"base": 60.0, "shoulder": 80.0, "elbow": -40.0, "wrist_pitch": 10.0}
    turns = [luck.uniform(low.get(n, -60.0), high.get(n, 60.0)) for n in arm.model.arm.joint_names]
    return Joints.of(*turns)


def goal_from(start: Joints, luck: Random) -> dict[str, float]:
    """Return a goal to which all joints turn, some far and some a little, in degrees."""
    most = luck.uniform(*TURN_DEG)
    return {
        f"{name}_deg": angle + luck.choice((-1, 1)) * most * luck.uniform(0.05, 1.0) * 0.5
        for name, angle in start.deg.items()
    }


def joint_motions(bench: DenseMemoryBench, times: int) -> list[tuple[Beside, float]]:
    """Drive motions straight in joint space; return how far each was beside, and its allowance."""
    arm, luck = bench.arm, chance("joints")
    assert arm is not None
    found: list[tuple[Beside, float]] = []
    while len(found) < times:
        start = posture(arm, luck)
        bench.bring(start)
        before, goal = bench.look().motors, goal_from(start, luck)
        try:
            handle = arm.move_j(wait=False, speed=luck.uniform(SLOWEST, 1.0), **goal)
        except OutOfBounds:
            continue  # into the table: another one
        seen = {each.motors for each in bench.watch(lambda: handle.done, PATIENCE_S)}  # noqa: B023
        moved = handle.wait()
        beside = _worst(StraightWay(bench, before, bench.look().motors), seen)
        step_mm = bench.step_mm(before)
        found.append((beside, line_allowance_mm(bench.config, step_mm, moved.deviation_mm)))
    return found


def plain_motions(bench: DenseMemoryBench, strategy: str, times: int) -> list[Beside]:
    """Send each drive to its target at one speed, as a program does that coordinates nothing."""
    arm, found, luck = bench.arm, [], chance("joints")
    assert arm is not None
    send = PLAIN[strategy].send
    for _ in range(times):
        start = posture(arm, luck)
        bench.bring(start)
        goal = goal_from(start, luck)
        speed = luck.uniform(SLOWEST, 1.0)
        turned = {name.removesuffix("_deg"): math.radians(turn) for name, turn in goal.items()}
        target = arm.parts.core.transmission.to_motors(start.replace(**turned), 20.0)
        before = bench.look().motors
        send(bench, target - before, speed)
        seen = set()
        while True:
            bench.sleep(DENSE_S)
            seen.add(bench.look().motors)
            if not bench.turning:
                break
        found.append(_worst(StraightWay(bench, before, bench.look().motors), seen))
    return found


def _worst(way: StraightWay, seen: set[Motors]) -> Beside:
    all_of_it = [way.beside(motors) for motors in seen]
    return Beside(max(e.tip_mm for e in all_of_it), max(e.joint_deg for e in all_of_it))


def of_joints(strategy: str, found: list[Beside], allowed: list[float]) -> Iterator[Figures]:
    """Return the figures of motions in joint space."""
    what = "joint motions: the tip beside its way"
    mm = [Measured(each.tip_mm, most) for each, most in zip(found, allowed, strict=True)]
    yield Figures(strategy, what, "mm", mm)
    degrees = [Measured(each.joint_deg) for each in found]
    yield Figures(strategy, "  a joint out of proportion", "deg", degrees)


def measure(options: Options, strategy: str) -> Iterator[Figures]:
    """Measure one strategy."""
    how = ALL[strategy]
    with DenseMemoryBench(how.dialect) as bench:
        bench.use_arm_file(how.section())
        arm = bench.ready()
        if strategy in PLAIN:
            plain = plain_motions(bench, strategy, options.times)
            yield from of_joints(strategy, plain, [math.inf] * len(plain))
            return
        driven = joint_motions(bench, options.times)
        yield from of_joints(strategy, [b for b, _ in driven], [mm for _, mm in driven])
        for kind in KINDS:
            luck, found = chance(how.dialect, kind), []
            for way in ways(arm, kind, luck, options.times):
                bench.bring(way.start)
                found.append(drawn(bench, way, luck.uniform(SLOWEST, 1.0)).anywhere)
            yield Figures(strategy, f"{kind}: anywhere", "mm", found)


def main(argv: list[str] | None = None) -> int:
    """Measure every strategy, or those that are asked for."""
    return report(
        argv,
        __doc__,
        measure,
        dialects=ALL,
        times=TIMES,
        quick_times=QUICK_TIMES,
        clocks=("simulated",),
        groups=groups(ALL),
    )


if __name__ == "__main__":
    sys.exit(main())
