"""A day of mixed work in simulated time: memory stays flat, nothing drifts, no step is lost.

    python -m tests.campaign.soak --jobs 2                   24 hours of each dialect
    python -m tests.campaign.soak --hours 1 --dialect grbl
    python -m tests.campaign.soak --lasting                one program all the time

After every call the physical arm is compared with the acknowledged position. Every hour the arm
returns to its start, where its motors must stand on the same steps. The exit code is 1 if they do
not, or if memory keeps growing.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import math
import random
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from statistics import median
from types import MappingProxyType

from armdrive.errors import Refused
from armdrive.registry import DIALECTS
from armdrive.status import State, Trust
from kinematics import KinematicsError, Motors

from .actions import ACTIONS, connect
from .laws import Broken, call, check_trust
from .physical import Command
from .stage import Stage

# -- Whether memory leaks: it keeps growing in the later half of a run -----------------------------
# A cache that fills is no leak: it fills early, and a leak goes on. So the last third of the
# figures is compared with the third before it, by their medians, which outliers do not change.

ALLOWED_KB: Mapping[str, float] = MappingProxyType(
    {
        # figures differ by some 3 kB; the rest is for caches that fill late
        "memory between two programs": 24.0,
        # the flight recorder keeps five minutes, which differ by some 100 kB
        "memory of the running program": 256.0,
        # Python takes memory from the system by the MB, and each rare maximum stays
        "memory of the process": 2048.0,
    }
)
"""How much each kind of figure may grow from the second third of a run to the last."""


def growth_kb(figures_kb: Sequence[float]) -> float:
    """Return how much the figures grow from the second third of a run to the last."""
    third = len(figures_kb) // 3
    return median(figures_kb[-third:]) - median(figures_kb[third:-third]) if third else 0.0


def judged(what: str, figures_kb: Sequence[float]) -> list[str]:
    """Return what is wrong with the figures of a run."""
    grown_kb, allowed_kb = growth_kb(figures_kb), ALLOWED_KB[what]
    if grown_kb <= allowed_kb:
        return []
    return [f"{what} keeps growing: {grown_kb:.0f} kB in a third of the run, not {allowed_kb:.0f}"]


# -- How much memory this process uses: by its live objects, and by the system's count -------------
# The objects are counted one by one on request. (Python's tracemalloc would make everything else
# several times slower.) Memory that C code has lost shows only in the system's count.

KB = 1024.0


@dataclass(frozen=True, slots=True)
class Census:
    """The bytes of all live objects, by the names of their types."""

    sizes: Mapping[str, int]

    @property
    def total_kb(self) -> float:
        """The kB of all objects."""
        return sum(self.sizes.values()) / KB

    def since(self, before: Census, most: int = 4) -> str:
        """Return the types that have grown most, in words."""
        grown = Counter(self.sizes)
        grown.subtract(before.sizes)
        rows = [(name, size / KB) for name, size in grown.most_common(most) if size > KB]
        return ", ".join(f"{name} {size_kb:+.0f} kB" for name, size_kb in rows) or "no type"


def census() -> Census:
    """Count the bytes of every object that a container leads to, each once.

    This misses only objects that C code holds without telling the collector.
    """
    gc.collect()
    found: list[object] = gc.get_objects()
    seen = {id(found), *map(id, found)}
    sizes: dict[str, int] = {}
    while found:
        for each in found:
            name = type(each).__name__
            sizes[name] = sizes.get(name, 0) + sys.getsizeof(each, 0)
        reached, found = gc.get_referents(*found), []
        for each in reached:
            # the collector does not list numbers and texts: only their owners lead to them
            if id(each) not in seen:
                seen.add(id(each))
                found.append(each)
        del reached
    return Census(MappingProxyType(sizes))


def process_kb() -> float:
    """Return the most memory that the process ever had, in kB; 0 if the system does not tell."""
    try:
        resource = importlib.import_module("resource")
    except ImportError:  # Windows
        return 0.0
    most = float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return most / KB if sys.platform == "darwin" else most


# -- One arm at work for hours, without faults, and the figures that are taken of it ---------------

HOUR_S = 3600.0
LEFT_OUT = ("disable", "estop", "home", "hold and vanish")
"""Actions after which a person has to reference the arm, or the program is gone."""
ENDING = "close and connect"
WARM_SHARE = 0.1
"""The share of a run after which memory is compared: the first work fills caches."""
LOOKS = 20
"""The least number of figures. A run of fewer hours takes them more often than every hour."""


@dataclass(frozen=True, slots=True)
class Figures:
    """The figures of one look."""

    hours: float
    calls: int
    refused: int
    memory_kb: float
    process_kb: float
    drift_steps: int
    took_s: float

    def __str__(self) -> str:
        return (
            f"{self.hours:6.2f} h  {self.calls:7d} calls, {self.refused} refused  "
            f"{self.memory_kb:8.1f} kB  process {self.process_kb / 1024:.1f} MB  "
            f"drift {self.drift_steps} steps  in {self.took_s:.0f} s"
        )


class Soak:
    """One arm at work, with one program after another, or with one that lasts."""

    def __init__(self, dialect: str, *, lasting: bool = False) -> None:
        self.stage = Stage(dialect, random.Random(f"soak {dialect} 0"), variant=0)
        self.calls = self.refused = 0
        self._lasting = lasting
        left_out = (*LEFT_OUT, ENDING) if lasting else LEFT_OUT
        names = [name for name in ACTIONS if name not in left_out]
        self._names, self._weights = names, [ACTIONS[name][1] for name in names]
        self._half: Census | None = None
        self._last: Census | None = None
        self._begin()
        self.start_deg = {f"{name}_deg": deg for name, deg in self.arm_deg().items()}
        self._opening_mm = self.stage.arm.parts.core.position.coordinates.opening_mm
        self.start = self._go_home()

    def arm_deg(self) -> dict[str, float]:
        """Return the joint angles that the driver acknowledges."""
        joints = self.stage.arm.parts.core.position.coordinates.joints
        return {name: math.degrees(rad) for name, rad in zip(joints.names, joints, strict=True)}

    def work(self, hours: float) -> Iterator[Figures]:
        """Work for some hours of simulated time; yield figures after the warm-up, then hourly."""
        began_s, start_s = time.monotonic(), self.stage.now_s
        end_s, every_s = start_s + hours * HOUR_S, min(hours / LOOKS, 1.0) * HOUR_S
        next_s = start_s + hours * HOUR_S * WARM_SHARE
        while True:
            while self.stage.now_s < next_s:
                self._one()
            drift = (self._go_home() - self.start).largest
            memory_kb = self._memory_kb(early=next_s - start_s <= (end_s - start_s) / 2)
            yield Figures(
                (self.stage.now_s - start_s) / HOUR_S,
                self.calls,
                self.refused,
                memory_kb,
                process_kb(),
                drift,
                time.monotonic() - began_s,
            )
            if next_s >= end_s:
                return
            # leave out a look just before the end of the run
            next_s = end_s if next_s + 1.5 * every_s > end_s else next_s + every_s

    def grown(self) -> str:
        """Return which types of objects have grown most since the middle of the run."""
        return self._last.since(self._half) if self._half and self._last else "unknown"

    def _one(self) -> None:
        stage = self.stage
        name = stage.draw.choices(self._names, self._weights)[0]
        error = ACTIONS[name][0](stage)
        self.calls += 1
        if isinstance(error, Refused | KinematicsError):
            self.refused += 1
        elif error is not None:
            raise Broken(f"{name}: {type(error).__name__}: {error}")
        if stage.arm.status.trust is not Trust.REFERENCED:
            self._ready()
        check_trust(stage)

    def _begin(self) -> None:
        """Connect a program; one that lasts has a flight recorder, as the desk has."""
        if self._lasting:
            options = {"allow_restored": False, "automatic": True}
            call(self.stage, lambda: self.stage.connect(**options))
        else:
            connect(self.stage)
        self._ready()

    def _ready(self) -> None:
        """Make the arm ready; confirm the record of the program before."""
        stage, arm = self.stage, self.stage.arm
        if arm.status.state is State.DISABLED:
            call(stage, arm.enable)
        if arm.status.trust is Trust.RESTORED:
            call(stage, arm.reference.confirm_restored)
        elif arm.status.trust is Trust.UNKNOWN and not self.calls:
            joints, opening_mm = stage.posture()
            call(stage, lambda: arm.reference.declare(joints, opening_mm=opening_mm))
        if arm.status.trust is not Trust.REFERENCED:
            raise Broken(f"the position was lost: {arm.status.trust_reason}")

    def _memory_kb(self, *, early: bool) -> float:
        """Return the memory in use; between two programs if there is more than one."""
        if not self._lasting:
            call(self.stage, self.stage.arm.close)
            self.stage.arm = None
        self._last = None
        self._last = census()
        if early:
            self._half = self._last
        if not self._lasting:
            self._begin()
        return self._last.total_kb

    def _go_home(self) -> Motors:
        """Return to the start, and return where the motors stand."""
        arm = self.stage.arm
        for act in (
            lambda: arm.move_j(**self.start_deg),
            lambda: arm.gripper.open(self._opening_mm),
        ):
            error = call(self.stage, act, Command("back to the start"), 120.0)
            if error is not None:
                raise Broken(f"the way back was refused: {error}")
        return self.stage.look()


# -- The run ---------------------------------------------------------------------------------------


def wrong_with(found: Sequence[Figures], *, lasting: bool = False) -> list[str]:
    """Return what is wrong with the figures of one arm."""
    what = "memory of the running program" if lasting else "memory between two programs"
    wrong = judged(what, [each.memory_kb for each in found])
    wrong += judged("memory of the process", [each.process_kb for each in found])
    return [*wrong, "it drifted"] if any(each.drift_steps for each in found) else wrong


def soak(dialect: str, hours: float, *, lasting: bool = False) -> list[str]:
    """Run one arm and print its figures; return what is wrong."""
    found: list[Figures] = []
    work = None
    try:
        work = Soak(dialect, lasting=lasting)
        for figures in work.work(hours):
            found.append(figures)
            sys.stdout.write(f"{dialect:12s}{figures}\n")
            sys.stdout.flush()
        wrong = wrong_with(found, lasting=lasting)
        if wrong:
            wrong.append(f"grown most: {work.grown()}")
    except Broken as law:
        wrong = [f"{law}, after {work.calls if work else 0} calls"]
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
