"""Benches on which the physical arm is looked at densely, and seen to move or to stand.

The conformance suite's own: in this process on simulated time, or in another one over a pty.
"""

from __future__ import annotations

import contextlib
import random
import sys
import time
from pathlib import Path
from typing import ClassVar

sys.path.insert(0, str(Path(__file__).parents[1]))
from armdrive.errors import ArmError
from armdrive.status import State
from kinematics import Joints, Motors
from tests.conformance.behaviour import cartesian
from tests.conformance.bench import Bench
from tests.conformance.memory_bench import MemoryBench
from tests.conformance.observation import Observation
from tests.conformance.real_time_bench import PtyBench

DENSE_S = 0.004


class DenseMemoryBench(MemoryBench):
    """The twin in this process, looked at every few ms of its own time."""

    look_s: ClassVar[float] = DENSE_S
    noise_s: ClassVar[float] = DENSE_S

    @property
    def turning(self) -> bool:
        """Whether motors turn."""
        return self.stage.twin.device.moving

    def bring(self, joints: Joints) -> None:
        """Have a person bring the arm to a posture, and say so; drives with encoders notice it."""
        arm = self.arm
        assert arm is not None
        self.stage.twin.device.bring_to(joints, self.look().opening_mm)
        with contextlib.suppress(ArmError):
            arm.parts.look()
        if arm.status.state is State.ERROR_STOP:
            arm.reset()
        self.reference(arm)


class DensePtyBench(PtyBench):
    """The device in another process."""

    noise_s: ClassVar[float] = PtyBench.look_s

    def __init__(self, dialect_name: str) -> None:
        super().__init__(dialect_name)
        self.turning = False

    def look(self) -> Observation:
        """Ask the console once, for where the motors are and whether they turn."""
        state = self._sim.state()
        self.turning = bool(state["moving"])
        motors = Motors(state["motors"])
        return Observation(time.monotonic(), motors, self.tip(motors), state["opening_mm"])


def knows_lines(bench: Bench) -> bool:
    """Tell whether the driver takes this arm's numbers for true, so that it draws lines."""
    return cartesian(bench) == ""


def chance(*words: object) -> random.Random:
    """Return a source of chance that is the same in every run."""
    return random.Random(" ".join(map(str, (1982, *words))))
