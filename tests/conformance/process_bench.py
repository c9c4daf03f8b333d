"""Benches in real time: the simulated device in another process, over a pty, TCP or UDP."""

from __future__ import annotations

import time
from typing import ClassVar

from armdrive.errors import BadRequest
from armdrive.registry import simulated_kind
from kinematics import Motors

from .device_process import DeviceProcess
from .fitted import arm_file
from .real_time_bench import RealTimeBench
from .seen import Seen


class ProcessBench(RealTimeBench):
    """`armdrive sim` in a process of its own, steered and looked at through its console."""

    def __init__(self, dialect_name: str) -> None:
        super().__init__(dialect_name)
        self._sim = self._start("armdrive", "sim", dialect_name)
        self.take_port(self._sim.port)

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
        path = self._home / "device.toml"
        path.write_text(arm_file(self.row, lines, "/dev/null"), encoding="utf-8")
        self._sim = self._start("tests.conformance.fitted", str(path), *settings)
        self.take_arm_file(lines, self._sim.port)

    @property
    def board(self) -> type:
        """The class of the simulated board."""
        return simulated_kind(self.row.name).board

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

    def end_device(self) -> None:
        """End the simulation."""
        self._sim.__exit__()

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
