"""One arm at work for hours, without faults, and the figures that are taken of it."""

import math
import random
import time
from collections.abc import Iterator
from dataclasses import dataclass

from armdrive.errors import Refused
from armdrive.status import State, Trust
from kinematics import KinematicsError, Motors

from .actions import ACTIONS, connect
from .laws import Broken, call, check_trust
from .physical import Command
from .soak_memory import Census, census, process_kb
from .stage import Stage

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

    def __init__(self, dialect: str, seed: int = 0, *, lasting: bool = False) -> None:
        self.stage = Stage(dialect, random.Random(f"soak {dialect} {seed}"), variant=0)
        self.calls = self.refused = 0
        self._lasting = lasting
        left_out = (*LEFT_OUT, ENDING) if lasting else LEFT_OUT
        names = [name for name in ACTIONS if name not in left_out]
        self._names, self._weights = names, [ACTIONS[name][1] for name in names]
        self._half: Census | None = None
        self._last: Census | None = None
        self._begin()
        self.start_deg = {f"{name}_deg": deg for name, deg in self.arm_deg().items()}
        self._opening_mm = self.stage.arm.core.position.coordinates.opening_mm
        self.start = self._go_home()

    def arm_deg(self) -> dict[str, float]:
        """Return the joint angles that the driver acknowledges."""
        joints = self.stage.arm.core.position.coordinates.joints
        return {name: math.degrees(rad) for name, rad in zip(joints.names, joints, strict=True)}

    def work(self, hours: float) -> Iterator[Figures]:
        """Work for some hours of the arm's time; yield figures after the warm-up, then hourly."""
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
            options = {"allow_restored": False, "automatic": True, "recorded": True}
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
            call(stage, arm.confirm_restored)
        elif arm.status.trust is Trust.UNKNOWN and not self.calls:
            joints, opening_mm = stage.posture()
            call(stage, lambda: arm.declare_posture(joints, opening_mm=opening_mm))
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
            lambda: arm.gripper.move(self._opening_mm),
        ):
            error = call(self.stage, act, Command("back to the start"), 120.0)
            if error is not None:
                raise Broken(f"the way back was refused: {error}")
        return self.stage.look()
