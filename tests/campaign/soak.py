"""A day of mixed work on simulated time: memory stays flat, nothing drifts, no step is lost.

    python -m tests.campaign.soak                            24 hours of each dialect
    python -m tests.campaign.soak --hours 1 --dialect grbl

After every call the physical arm is compared with the position that is acknowledged, and every
hour it goes back to where it began, where its motors have to stand on the very same steps. Exit
code 1 where they do not, or where memory has grown.
"""

from __future__ import annotations

import argparse
import gc
import math
import random
import sys
import time
import tracemalloc
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from armdrive.dialects import DIALECTS
from armdrive.errors import Refused
from armdrive.status import State, Trust
from kinematics import KinematicsError, Motors

from .actions import ACTIONS, connect
from .laws import Broken, call, honest
from .physical import Command
from .stage import Stage

HOUR_S = 3600.0
LEFT_OUT = ("disable", "estop", "home")
"""After these a person has to look at the arm, or it counts anew."""
GROWTH_KB = 128.0
"""What a day may add to the memory that is in use: caches fill, and no more."""
WARM_SHARE = 0.1
"""Memory is compared from here on: the first work fills caches."""
SHORTEST_WARM_S = 300.0


@dataclass(frozen=True, slots=True)
class Figures:
    """What was seen at the end of an hour, or of the whole."""

    hours: float
    calls: int
    refused: int
    memory_kb: float
    drift_steps: int
    took_s: float

    def __str__(self) -> str:
        return (
            f"{self.hours:6.1f} h  {self.calls:7d} calls, {self.refused} refused  "
            f"{self.memory_kb:8.0f} kB  drift {self.drift_steps} steps  in {self.took_s:.0f} s"
        )


class Soak:
    """One arm at work."""

    def __init__(self, dialect: str, seed: int = 0) -> None:
        self.stage = Stage(dialect, random.Random(f"soak {dialect} {seed}"), variant=0)
        self.calls = self.refused = 0
        names = [name for name in ACTIONS if name not in LEFT_OUT]
        self._names, self._weights = names, [ACTIONS[name][1] for name in names]
        connect(self.stage)
        self._ready()
        self.start_deg = {f"{name}_deg": deg for name, deg in self.arm_deg().items()}
        self._opening_mm = self.stage.arm.core.coordinates.opening_mm
        self.start = self._go_home()

    def arm_deg(self) -> dict[str, float]:
        """Return the angles at present."""
        joints = self.stage.arm.core.coordinates.joints
        return {name: math.degrees(rad) for name, rad in zip(joints.names, joints, strict=True)}

    def work(self, hours: float) -> Iterator[Figures]:
        """Work for so many hours of the arm's time; give figures each hour, and at the end."""
        began_s, end_s = time.monotonic(), self.stage.now_s + hours * HOUR_S
        start_s = next_s = self.stage.now_s
        warm_s = start_s + max(hours * HOUR_S * WARM_SHARE, SHORTEST_WARM_S)
        next_s = min(warm_s, end_s)
        while True:
            while self.stage.now_s < next_s:
                self._one()
            drift = (self._go_home() - self.start).largest
            yield Figures(
                (self.stage.now_s - start_s) / HOUR_S,
                self.calls,
                self.refused,
                self._memory_kb(),
                drift,
                time.monotonic() - began_s,
            )
            if next_s >= end_s:
                return
            next_s = min(next_s + HOUR_S, end_s)

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
        honest(stage)

    def _ready(self) -> None:
        """Have the arm ready: of a program that has just begun, its record is confirmed."""
        stage, arm = self.stage, self.stage.arm
        if arm.status.state is State.DISABLED:
            call(stage, arm.enable)
        if arm.status.trust is Trust.RESTORED:
            call(stage, arm.confirm_restored)
        elif arm.status.trust is Trust.UNKNOWN and not self.calls:
            joints, opening_mm = stage.posture()
            call(stage, lambda: arm.declare_posture(joints, opening_mm=opening_mm))
        if arm.status.trust is not Trust.REFERENCED:
            raise Broken(f"the position was lost: {arm.status.trust_reason}")

    def _memory_kb(self) -> float:
        """Return what is in use between two programs: a ring that fills is no leak."""
        call(self.stage, self.stage.arm.close)
        self.stage.arm = None
        gc.collect()
        used_kb = tracemalloc.get_traced_memory()[0] / 1024.0
        connect(self.stage)
        self._ready()
        return used_kb

    def _go_home(self) -> Motors:
        """Go back to where it began, and look where the motors stand."""
        arm = self.stage.arm
        for act in (
            lambda: arm.move_j(**self.start_deg),
            lambda: arm.gripper.move(self._opening_mm),
        ):
            error = call(self.stage, act, Command("back to the start"), 120.0)
            if error is not None:
                raise Broken(f"the way back was refused: {error}")
        return self.stage.look()


def soak(dialect: str, hours: float) -> list[str]:
    """Work one arm; print its figures, and return what is wrong with them."""
    tracemalloc.start()
    wrong: list[str] = []
    try:
        found = []
        for figures in Soak(dialect).work(hours):
            found.append(figures)
            sys.stdout.write(f"{dialect:12s}{figures}\n")
            sys.stdout.flush()
        grown_kb = found[-1].memory_kb - found[0].memory_kb
        if grown_kb > GROWTH_KB:
            wrong.append(f"{dialect}: memory has grown by {grown_kb:.0f} kB")
        if any(each.drift_steps for each in found):
            wrong.append(f"{dialect}: it drifted")
    except Broken as law:
        wrong.append(f"{dialect}: {law}")
    finally:
        tracemalloc.stop()
    return wrong


def main(words: Sequence[str] | None = None) -> int:
    """Work the arms that are asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign.soak", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--dialect", action="append", choices=list(DIALECTS))
    chosen = parser.parse_args(words)
    wrong = [line for name in chosen.dialect or DIALECTS for line in soak(name, chosen.hours)]
    sys.stdout.write("\n".join(wrong or ["flat, no drift, no step lost"]) + "\n")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
