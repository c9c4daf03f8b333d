"""Benches in real time: a port, and behind it the device in another process, or a real arm.

They wait on the wall clock. Drivers and devices may be late on a busy computer.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar, cast

from filelock import FileLock

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import find
from armdrive.dialog.operator import Operator
from armdrive.errors import ArmError, BadRequest, Refused
from armdrive.registry import simulated_kind
from armdrive.sim.simulated_arm import SimulatedOperator
from armdrive.sim.world.arm import World
from armdrive.sim.world.body import ArmBody, found_posture
from armdrive.status import State, Status, Trust
from kinematics import Joints, Motors

from .bench import Bench
from .fitted import arm_file
from .seen import Seen

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from sim_process import SimProcess

ROOT = Path(__file__).parents[2]


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


SCHEMES = {"--pty": "", "--slcan": "", "--tcp": "socket://", "--udp": "udp://"}
"""What a program opens, before the address that the device names."""


class DeviceProcess(SimProcess):
    """`program` with one door, `--pty PATH` say; its `port` is what a driver opens."""

    def __init__(self, program: Sequence[str], door: tuple[str, str], dialect: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", *program, *door],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        where, _ = door
        told = self._heard().partition(f" speaks {dialect} at ")[2].partition(";")[0]
        self.port = SCHEMES[where] + told


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


SLOWLY = 0.3


def port_lock(port: str) -> FileLock:
    """Return the lock of a port: tests take turns on it, whichever process they run in.

    The driver's own lock lies under `ARMDRIVE_HOME`, of which every test has another one.
    """
    name = hashlib.sha256(str(Path(port).resolve()).encode()).hexdigest()[:16]
    return FileLock(Path(tempfile.gettempdir()) / f"armdrive-bench-{name}.lock")


class PortBench(RealTimeBench):
    """A real arm, which stands in its reference posture when the first row begins."""

    transport: ClassVar[str] = "port"
    look_s: ClassVar[float] = 0.02
    simulated: ClassVar[bool] = False
    sees_motion: ClassVar[bool] = False
    _begun: ClassVar[bool] = False

    def __init__(self, dialect_name: str, port: str) -> None:
        super().__init__(dialect_name)
        self._lock = port_lock(port)
        self._lock.acquire()
        self.take_port(port)
        self._last = Motors([0] * self.row.abilities.motors)

    def end_device(self) -> None:
        """Let others have the port."""
        self._lock.release()

    def look(self) -> Seen:
        """Ask a standing arm for its registers; of a moving one, take what was told last."""
        if self.arm is not None:
            self._last = _told(self.arm, self._last)
        return Seen(time.monotonic(), self._last, self.tip(self._last), self.posture(self._last)[1])

    def refer(self, arm: Arm) -> None:
        """Confirm what the last row has left behind; of the first, the reference posture.

        Before the run the person beside the arm has brought it to its reference posture. It then
        goes to where simulated arms are found: raised, and clear of the table.
        """
        self.switch_on(arm)
        trust = arm.status.trust
        if trust is Trust.RESTORED:
            arm.confirm_restored()
        elif trust is Trust.UNKNOWN and not self._begun:
            arm.confirm_reference()
        else:
            raise Refused(
                f"the position is {trust.value}: bring the arm to its reference posture and begin "
                "anew with the rows that are left"
            )
        type(self)._begun = True
        found = found_posture(arm.model.arm)
        arm.move_j(speed=SLOWLY, **{f"{name}_deg": angle for name, angle in found.deg.items()})

    def operator(self) -> Operator:
        """Nobody is asked in the middle of a test."""
        raise Refused("a real arm is referenced by `armdrive home`")

    def fault(self, words: str) -> None:
        """Nobody harms a real arm."""
        raise Refused(f"no fault is made on a real arm: {words}")

    def heal(self) -> None:
        """Nothing was harmed."""


def _told(arm: Arm, last: Motors) -> Motors:
    status: Status = arm.status
    if status.state in (State.STANDBY, State.DISABLED):
        try:
            arm.read_inputs()
        except ArmError:
            return last
        status = arm.status
    return status.read_back or last
