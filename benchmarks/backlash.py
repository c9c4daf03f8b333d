"""What compensated backlash is worth: `python benchmarks/backlash.py [DIALECT ...] [--json]`.

Simulated arms whose every motor has a play of 12 steps, driven without knowing of it, and with the
same backlash in the arm file. The physical tip is compared with where the arm is said to be after
moves at random, and with the straight lines that were asked for, every 5 ms; in these, the shoulder
and the elbow turn round in the middle, and the base at the ends. On simulated time.
"""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from measuring import Row, Section, report

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "armdrive"))
from backlash_bench import DIALECTS, PLAY, arm_with_play

from armdrive import Arm, Pose
from tests.conformance.observation import Point, place

LOOK_S = 0.005
MOVES, LINES = 20, 3
POSTURE = {"base": 0.0, "shoulder": 42.0, "elbow": -75.0, "wrist_pitch": -30.0}
START, WAY_MM = (300.0, -70.0, 120.0), 140.0
ARMS = {"no play": (0, 0), "play": (PLAY, 0), "play, compensated": (PLAY, PLAY)}
"""By name: the play of the physical arm, and the backlash that the driver takes up."""


def tip(arm: Arm) -> Point:
    """Return where the physical tip is."""
    assert arm.twin is not None
    return arm.twin.world.tip


def after_moves_mm(arm: Arm) -> float:
    """Return how far the tip was at most from where it was said to be."""
    luck, worst_mm = random.Random(5), 0.0
    for _ in range(MOVES):
        goal = {f"{name}_deg": deg + luck.uniform(-5.0, 5.0) for name, deg in POSTURE.items()}
        arm.move_j(goal, speed=1.0)
        worst_mm = max(worst_mm, math.dist(tip(arm), place(arm.pose)))
    return worst_mm


def beside_lines(arm: Arm) -> tuple[float, float]:
    """Return how far the tip was at most beside its lines anywhere, and at their ends."""
    x_mm, y_mm, z_mm = START
    start = Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=-70.0)
    end = replace(start, y_mm=y_mm + WAY_MM)
    arm.move_to(start)
    way_mm = ends_mm = 0.0
    for number in range(2 * LINES):
        handle = arm.move_l(start if number % 2 else end, speed=0.5, wait=False)
        while not handle.done:
            arm.sleep(LOOK_S)
            way_mm = max(way_mm, beside_mm(tip(arm), place(start)))
        handle.wait()
        ends_mm = max(ends_mm, math.dist(tip(arm), place(arm.pose)))
    return way_mm, ends_mm


def beside_mm(point: Point, start: Point) -> float:
    """Return the distance from a line along y."""
    return math.hypot(point[0] - start[0], point[2] - start[2])


def measured(dialect: str) -> Iterator[Row]:
    """Give the figures of one dialect's arm."""
    for name, (play, backlash) in ARMS.items():
        yield Row(
            f"{name}: after moves",
            after_moves_mm(arm_with_play(dialect, play=play, backlash=backlash)),
            "mm",
        )
        way_mm, ends_mm = beside_lines(arm_with_play(dialect, play=play, backlash=backlash))
        yield Row(f"{name}: at the ends of lines", ends_mm, "mm")
        yield Row(f"{name}: beside lines, anywhere", way_mm, "mm")


def section(dialect: str) -> Section:
    """Measure one dialect."""
    title = f"{dialect}, {PLAY} steps of play in every motor's train"
    return Section(title, tuple(measured(dialect)), "the worst")


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(argv, __doc__, {dialect: partial(section, dialect) for dialect in DIALECTS})


if __name__ == "__main__":
    sys.exit(main())
