"""A day of mixed work in simulated time: memory stays flat, nothing drifts, no step is lost.

    python -m tests.campaign.soak --jobs 2                   24 hours of each dialect
    python -m tests.campaign.soak --hours 1 --dialect grbl
    python -m tests.campaign.soak --lasting                one program all the time

After every call the physical arm is compared with the acknowledged position. Every hour the arm
returns to its start, where its motors must stand on the same steps. The exit code is 1 if they do
not, or if memory keeps growing.
"""

import argparse
import gc
import random
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from statistics import median

from armdrive.errors import Refused
from armdrive.registry import DIALECTS
from armdrive.status import State, Trust
from kinematics import KinematicsError
from tests.conformance.observation import Broken, check
from tests.scenarios.actions import ACTIONS, close_and_connect, connect, move_to_joints
from tests.scenarios.laws import call, check_trust
from tests.scenarios.stage import Stage
from tests.scenarios.watch import Command

from .arms import config_of

HOUR_S = 3600.0
LEFT_OUT = ("disable", "estop", "home", "hold and vanish")
"""Actions after which a person has to reference the arm, or the program is gone."""
LOOKS = 20
"""The least number of figures. A run of fewer hours takes them more often than every hour."""
OBJECTS = 400.0
"""How much the live objects may grow from the second third of a run to the last. Caches that fill
late, and a flight recorder, differ by less."""


def growth(figures: Sequence[float]) -> float:
    """Return how much the figures grow from the second third of a run to the last.

    A cache that fills is no leak: it fills early. Medians ignore outliers.
    """
    third = len(figures) // 3
    return median(figures[-third:]) - median(figures[third:-third]) if third else 0.0


@dataclass(frozen=True, slots=True)
class Figures:
    """The figures of one look."""

    hours: float
    calls: int
    objects: int
    drift_steps: int

    def __str__(self) -> str:
        return (
            f"{self.hours:6.2f} h  {self.calls:7d} calls  {self.objects} objects  "
            f"drift {self.drift_steps} steps"
        )


def wrong_with(found: Sequence[Figures]) -> list[str]:
    """Return what is wrong with the figures of one arm."""
    more = growth([each.objects for each in found])
    wrong = [f"{more:.0f} more live objects in a third of the run"] if more > OBJECTS else []
    return [*wrong, "it drifted"] if any(each.drift_steps for each in found) else wrong


def work(dialect: str, hours: float, *, lasting: bool = False) -> Iterator[Figures]:
    """Let an arm work for some hours, with one program after another or one that lasts.

    Yields figures at regular times. Raises `Broken`.
    """
    stage, draw = Stage(config_of(dialect, 0)), random.Random(f"soak {dialect} 0")
    if lasting:
        call(stage, partial(stage.connect, automatic=True))
    else:
        connect(stage, draw)
    names = [name for name in ACTIONS if name not in LEFT_OUT]
    if lasting:
        names.remove("close and connect")
    weights = [ACTIONS[name][1] for name in names]
    _reference(stage)
    start, start_s = stage.look(), stage.now_s
    joints, opening_mm = stage.posture()
    calls, every_s = 0, min(hours / LOOKS, 1.0) * HOUR_S
    while stage.now_s < start_s + hours * HOUR_S:
        next_s = stage.now_s + every_s
        while stage.now_s < next_s:
            _one(stage, draw, draw.choices(names, weights)[0])
            calls += 1
        _well(move_to_joints(stage, joints.deg, 60.0))
        assert stage.arm is not None
        gripper: Callable[[], object] = partial(stage.arm.gripper.open, opening_mm)
        _well(call(stage, gripper, Command("back to the start"), 120.0))
        drift = (stage.look() - start).largest
        if not lasting:
            close_and_connect(stage, draw)
            _reference(stage)
        gc.collect()
        hours_s = stage.now_s - start_s
        yield Figures(hours_s / HOUR_S, calls, len(gc.get_objects()), drift)


def _one(stage: Stage, draw: random.Random, name: str) -> None:
    error = ACTIONS[name][0](stage, draw)
    if not isinstance(error, Refused | KinematicsError):
        _well(error)
    _reference(stage)
    check_trust(stage)


def _well(error: Exception | None) -> None:
    check(error is None, f"{type(error).__name__}: {error}")


def _reference(stage: Stage) -> None:
    """Make the arm ready; confirm the record of the program before."""
    arm = stage.arm
    assert arm is not None
    if arm.status.state is State.DISABLED:
        call(stage, arm.enable)
    if arm.status.trust is Trust.RESTORED:
        call(stage, arm.reference.confirm_restored)
    elif arm.status.trust is Trust.UNKNOWN and stage.now_s < 1.0:
        joints, opening_mm = stage.posture()
        call(stage, lambda: arm.reference.declare(joints, opening_mm=opening_mm))
    trusted = arm.status.trust is Trust.REFERENCED
    check(trusted, f"the position was lost: {arm.status.trust_reason}")


def soak(dialect: str, hours: float, *, lasting: bool = False) -> list[str]:
    """Run one arm and print its figures; return what is wrong."""
    found: list[Figures] = []
    try:
        for figures in work(dialect, hours, lasting=lasting):
            found.append(figures)
            sys.stdout.write(f"{dialect:12s}{figures}\n")
            sys.stdout.flush()
        wrong = wrong_with(found)
    except Broken as law:
        wrong = [str(law)]
    return [f"{dialect}: {line}" for line in wrong]


def main(words: Sequence[str] | None = None) -> int:
    """Run the chosen arms, each in a process of its own; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign.soak", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--dialect", action="append", choices=list(DIALECTS))
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--lasting", action="store_true", help="one program all the time")
    chosen = parser.parse_args(words)
    one = partial(soak, hours=chosen.hours, lasting=chosen.lasting)
    with get_context("spawn").Pool(chosen.jobs, maxtasksperchild=1) as pool:
        wrong = [line for lines in pool.imap(one, chosen.dialect or DIALECTS, 1) for line in lines]
    sys.stdout.write("\n".join(wrong or ["flat, no drift, no step lost"]) + "\n")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
