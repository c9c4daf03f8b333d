"""What every bench in real time does alike: it opens a port, and waits on the wall clock."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, cast

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import find
from armdrive.dialog.operator import Operator
from armdrive.sim.simulated_arm import SimulatedOperator
from armdrive.sim.world.arm import World
from armdrive.sim.world.body import ArmBody
from kinematics import Joints, Motors

from .bench import Bench
from .fitted import arm_file


class SeenWorld:
    """As much of an arm's world as an operator has to see, on a bench that sees the motors."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.body = ArmBody.of_preset(bench.config.model)

    @property
    def motors(self) -> Motors:
        """Where the motors are, physically."""
        return self._bench.look().motors

    @property
    def joints(self) -> Joints:
        """The joint angles, physically."""
        return self._bench.posture(self.motors)[0]


class RealTimeBench(Bench):
    """A device on a port of this computer. `port` is what a driver opens: a port or an arm file."""

    real_time: ClassVar[bool] = True
    look_s: ClassVar[float] = 0.002
    noise_s: ClassVar[float] = 0.25

    port: str
    device_port: str
    """The port itself, where drivers open an arm file."""
    _config: ArmConfig

    def __init__(self, dialect_name: str) -> None:
        super().__init__(dialect_name)
        self._folder = tempfile.TemporaryDirectory(prefix="conformance-")
        self._home = Path(self._folder.name)
        self._timers: list[threading.Timer] = []

    def take_port(self, port: str) -> None:
        """Have drivers open a port, as somebody does who has no arm file."""
        self.port = self.device_port = port
        self._config = find(port, dialect_name=self.row.name).config

    def take_arm_file(self, lines: str, port: str) -> None:
        """Have drivers open an arm file that says more than its preset: `lines` of TOML."""
        path = self._home / "bench.toml"
        path.write_text(arm_file(self.row, lines, port), encoding="utf-8")
        self.port, self.device_port = str(path), port
        self._config = find(self.port).config

    @property
    def config(self) -> ArmConfig:
        """The arm as the driver is told of it."""
        return self._config

    def _open(self, **options: Any) -> Arm:
        return Arm.connect(self.port, dialect=self.row.name, **options)

    def sleep(self, time_s: float) -> None:
        """Sleep."""
        time.sleep(time_s)

    def later(self, time_s: float, call: Callable[[], object]) -> None:
        """Have a thread do it."""
        timer = threading.Timer(time_s, call)
        timer.daemon = True
        timer.start()
        self._timers.append(timer)

    def operator(self) -> Operator:
        """Return a simulated operator who looks at the arm on the bench."""
        world = cast(World, SeenWorld(self))
        return SimulatedOperator(world, backlash_steps=self.config.backlash_steps)

    def end_device(self) -> None:
        """End the device, where the bench has begun it."""

    def close(self) -> None:
        """End the driver and the device, and forget the arm file."""
        try:
            super().close()
        finally:
            for timer in self._timers:
                timer.cancel()
            self.end_device()
            self._folder.cleanup()
