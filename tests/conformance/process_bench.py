"""Benches in real time: the simulated device in another process, over a pty, TCP or UDP."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, cast

from armdrive.arm import Arm
from armdrive.armfile import ArmConfig
from armdrive.connecting import find
from armdrive.errors import BadRequest
from armdrive.posture import Operator
from armdrive.sim.body import ArmBody
from armdrive.sim.operator import SimulatedOperator
from armdrive.sim.twins import twin_kind
from armdrive.sim.world import World
from kinematics import Joints, Motors

from .bench import Bench
from .device_process import DeviceProcess
from .fitted import arm_file
from .seen import Seen


class SeenWorld:
    """As much of another process's world as an operator has to see."""

    def __init__(self, bench: ProcessBench) -> None:
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


class ProcessBench(Bench):
    """`armdrive sim` in a process of its own, steered and looked at through its console."""

    real_time: ClassVar[bool] = True
    look_s: ClassVar[float] = 0.002
    noise_s: ClassVar[float] = 0.25

    def __init__(self, dialect_name: str) -> None:
        super().__init__(dialect_name)
        self._folder = tempfile.TemporaryDirectory(prefix="conformance-")
        self._home = Path(self._folder.name)
        self._sim = self._start("armdrive", "sim", dialect_name)
        self.port = self._sim.port
        self._config = find(self.port, dialect_name=dialect_name).config

    def _door(self) -> tuple[str, str]:
        """Return the option of `armdrive sim` that offers the device, and its address."""
        raise NotImplementedError

    def _start(self, *program: str) -> DeviceProcess:
        return DeviceProcess(program, self._door(), self.row.name)

    def fit(self, lines: str, *settings: str) -> None:
        """End the device, and begin one of an arm file, by whose path the driver connects.

        The `settings` of the device are written NAME=VALUE.
        """
        self.leave()
        self._sim.__exit__()
        path = self._home / "bench.toml"
        path.write_text(arm_file(self.row, lines, "/dev/null"), encoding="utf-8")
        self._sim = self._start("tests.conformance.fitted", str(path), *settings)
        path.write_text(arm_file(self.row, lines, self._sim.port), encoding="utf-8")
        self.port = str(path)
        self._config = find(self.port).config

    def later(self, time_s: float, call: Callable[[], object]) -> None:
        """Have a thread do it."""
        timer = threading.Timer(time_s, call)
        timer.daemon = True
        timer.start()

    @property
    def config(self) -> ArmConfig:
        """The arm as somebody has it who opens a port without an arm file."""
        return self._config

    @property
    def device(self) -> type:
        """The class of the simulated device."""
        return twin_kind(self.row.name).device

    def _open(self, **options: Any) -> Arm:
        return Arm.connect(self.port, dialect=self.row.name, **options)

    def look(self) -> Seen:
        """Ask the console for the physical state."""
        state = self._sim.state()
        motors = Motors(state["motors"])
        return Seen(
            time.monotonic(),
            motors,
            self.tip(motors),
            state["opening_mm"],
            state["energised"],
            state["powered"],
        )

    def sleep(self, time_s: float) -> None:
        """Sleep."""
        time.sleep(time_s)

    def operator(self) -> Operator:
        """Return a simulated operator who looks at the other process's arm."""
        return SimulatedOperator(cast(World, SeenWorld(self)))

    def close(self) -> None:
        """End the driver and the simulation."""
        try:
            super().close()
        finally:
            self._sim.__exit__()
            self._folder.cleanup()

    def fault(self, words: str) -> None:
        """Have a fault, at the console."""
        self._tell(f"fault {words}")

    def heal(self) -> None:
        """End every fault."""
        self._tell("fault off")

    def replug_elsewhere(self) -> None:
        """Put the cable back under another name."""
        there = str(self._home / "elsewhere")
        self.port = self.port.replace(str(self._home / "arm"), there)
        self._tell(f"replug as {there}")

    def _tell(self, line: str) -> str:
        """Give the console a command; raises `BadRequest` where it was refused."""
        answer = self._sim.say(f"{line} --json")
        if '"ok": false' in answer:
            raise BadRequest(answer)
        return answer


class PtyBench(ProcessBench):
    """Over a pseudo-terminal: a serial line, or a serial CAN adapter and the bus behind it."""

    transport: ClassVar[str] = "pty"
    on_bus: ClassVar[bool] = True

    def _door(self) -> tuple[str, str]:
        return "--slcan" if self.row.can else "--pty", str(self._home / "arm")


class TcpBench(ProcessBench):
    """Over TCP."""

    transport: ClassVar[str] = "tcp"

    def _door(self) -> tuple[str, str]:
        return "--tcp", "127.0.0.1:0"


class UdpBench(ProcessBench):
    """Over UDP: datagrams that nobody paces, and that nobody knows to have arrived."""

    transport: ClassVar[str] = "udp"

    def _door(self) -> tuple[str, str]:
        return "--udp", "127.0.0.1:0"
