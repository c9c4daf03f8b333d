"""How fast simulated time passes: the demonstration, and a long series of random moves."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from statistics import median

from measuring import Row, Section

from armdrive import Arm, Pose
from armdrive.cli.program.demo import JOBS, blocks_of, misplaced, perform
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry import simulate

SEED = 1982
RISE_MM = 80.0
"""From the reference mark straight up: the fingers begin on the table."""


def demonstration() -> Arm:
    """Stack the blocks, and return the arm that did it, closed."""
    config = simulated_config("teachmover")
    twin = simulate(config, blocks=blocks_of(JOBS))
    with Arm(connect_simulated(config, twin=twin)) as arm:
        perform(arm, JOBS, lambda _: None)
    wrong = misplaced(twin.world, JOBS)
    if wrong:
        raise RuntimeError("; ".join(wrong))
    return arm


def random_moves(count: int) -> Arm:
    """Move from one random pose to the next, and return the arm that did it, closed."""
    chance = random.Random(SEED)
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        mark = arm.pose
        arm.move_l(Pose(mark.x_mm, mark.y_mm, RISE_MM, mark.pitch_rad))
        for _ in range(count):
            arm.move_to(
                Pose.of(
                    x_mm=chance.uniform(200.0, 300.0),
                    y_mm=chance.uniform(-150.0, 150.0),
                    z_mm=chance.uniform(80.0, 200.0),
                    pitch_deg=-90.0,
                )
            )
    return arm


def _paced(work: Callable[[], Arm]) -> tuple[float, float]:
    """Return the arm's seconds and the computer's."""
    began_s = time.perf_counter()
    arm = work()
    return arm.pace.now_s(), time.perf_counter() - began_s


def simulated_time(rounds: int = 7, moves: int = 300) -> Section:
    """Measure both in turn, from connecting to closing."""
    works = {
        "the demonstration": demonstration,
        f"{moves} random move_to": lambda: random_moves(moves),
    }
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in works}
    for _ in range(rounds):
        for name, work in works.items():
            found[name].append(_paced(work))
    rows = tuple(
        Row(
            f"{name} ({median(s for s, _ in each):.0f} s of the arm's time)",
            median(simulated_s / real_s for simulated_s, real_s in each),
            "simulated s per real s",
        )
        for name, each in found.items()
    )
    return Section("Simulated time", rows, f"medians of {rounds} rounds, in process")
