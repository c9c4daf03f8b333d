"""Benches in real time: a port with a device in another process, or with a real arm.

They wait on the wall clock. Drivers and devices may be late on a busy computer.
"""

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
from armdrive.dialog import Operator
from armdrive.errors import ArmError, BadRequest, Refused
from armdrive.registry import simulated_kind
from armdrive.sim.simulated_arm import SimulatedOperator
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody, found_posture
from armdrive.status import State, Status, Trust
from kinematics import Joints, Motors

from .bench import Bench
from .custom_arm import arm_file
from .observation import Observation

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from sim_process import SimProcess

ROOT = Path(__file__).parents[2]


class ObservedWorld:
    """The part of an arm's world that an operator needs, observed by a bench."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.body = ArmBody.of_preset(bench.config.model)

    @property
    def motors(self) -> Motors:
        """Where the physical motors stand."""
        return self._bench.look().motors

    @property
    def joints(self) -> Joints:
        """The joint angles of the physical arm."""
        return self._bench.posture(self.motors)[0]


class RealTimeBench(Bench):
    """A device on a port of this computer. A driver opens `port`: a port or an arm file."""

    real_time: ClassVar[bool] = True
    look_s: ClassVar[float] = 0.002
    noise_s: ClassVar[float] = 0.25

    port: str
    device_port: str
    """The device's port, also if drivers open an arm file."""
    _config: ArmConfig

    def __init__(self, dialect_name: str) -> None:
        super().__init__(dialect_name)
        self._folder = tempfile.TemporaryDirectory(prefix="conformance-")
        self._home = Path(self._folder.name)
        self._timers: list[threading.Timer] = []

    def set_port(self, port: str) -> None:
        """Make drivers open a port without an arm file."""
        self.port = self.device_port = port
        self._config = find(port, dialect_name=self.row.name).config

    def set_arm_file(self, lines: str, port: str) -> None:
        """Make drivers open an arm file with more `lines` of TOML than its preset."""
        path = self._home / "bench.toml"
        path.write_text(arm_file(self.row, lines, port), encoding="utf-8")
        self.port, self.device_port = str(path), port
        self._config = find(self.port).config

    @property
    def config(self) -> ArmConfig:
        """The configuration that the driver gets."""
        return self._config

    def _open(self, **options: Any) -> Arm:
        return Arm.connect(self.port, dialect=self.row.name, **options)

    def sleep(self, time_s: float) -> None:
        """Sleep."""
        time.sleep(time_s)

    def call_later(self, time_s: float, call: Callable[[], object]) -> None:
        """Call a function from another thread, in `time_s`."""
        timer = threading.Timer(time_s, call)
        timer.daemon = True
        timer.start()
        self._timers.append(timer)

    def operator(self) -> Operator:
        """Return a simulated operator who looks at the arm on the bench."""
        world = cast(World, ObservedWorld(self))
        return SimulatedOperator(world, backlash_steps=self.config.backlash_steps)

    def end_device(self) -> None:
        """End the device if the bench has started it."""

    def close(self) -> None:
        """End the driver and the device, and forget the arm file."""
        try:
            super().close()
        finally:
            for timer in self._timers:
                timer.cancel()
            self.end_device()
            self._folder.cleanup()


class DeviceProcess(SimProcess):
    """A program that serves a device by one option and address; a driver opens its `port`.

    `door` is the option with its address, such as `--pty PATH`.
    """

    def __init__(self, program: Sequence[str], door: tuple[str, str], dialect: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", *program, *door],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self.port = self.told_port(dialect)
        if "--arm" in program:
            self._heard()  # the port that the arm file has to name


class ProcessBench(RealTimeBench):
    """`armdrive sim` in a process of its own, controlled and observed through its console.

    With `lines` the arm has a file with these lines more, as by `use_arm_file`.
    """

    def __init__(self, dialect_name: str, lines: str = "") -> None:
        super().__init__(dialect_name)
        self._begin(lines)

    def _begin(self, lines: str) -> None:
        if lines:
            self._serve_arm_file(lines)
        else:
            self._sim = self._start("armdrive", "sim", self.row.name)
            self.set_port(self._sim.port)

    def _door(self) -> tuple[str, str]:
        """Return the option of `armdrive sim` that serves the device, and its address."""
        raise NotImplementedError

    def _start(self, *program: str) -> DeviceProcess:
        return DeviceProcess(program, self._door(), self.row.name)

    def use_arm_file(self, lines: str, *settings: str) -> None:
        """Start another device, with an arm file of more lines; the driver connects by this file.

        The device's `settings` are written NAME=VALUE.
        """
        self.disconnect()
        self._sim.__exit__()
        self._serve_arm_file(lines, *settings)

    def _serve_arm_file(self, lines: str, *settings: str) -> None:
        words = [word for each in settings for word in ("--set", each)]
        path = self._home / "device.toml"
        path.write_text(arm_file(self.row, lines, "/dev/null"), encoding="utf-8")
        self._sim = self._start("armdrive", "sim", "--arm", str(path), *words)
        self.set_arm_file(lines, self._sim.port)

    @property
    def board(self) -> type:
        """The class of the simulated board."""
        return simulated_kind(self.row.name).board

    def look(self) -> Observation:
        """Ask the console for the physical state."""
        state = self._sim.state()
        motors = Motors(state["motors"])
        return Observation(
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
        """Inject a fault through the console."""
        self._tell(f"fault {words}")

    def heal(self) -> None:
        """End every fault."""
        self._tell("fault off")

    def replug_elsewhere(self) -> None:
        """Put the cable back; the port has another name from now on."""
        there = str(self._home / "elsewhere")
        self.port = self.port.replace(str(self._home / "arm"), there)
        self._tell(f"replug as {there}")

    def _tell(self, line: str) -> str:
        """Send the console a command. Raises `BadRequest` if the console refuses it."""
        answer = self._sim.say(f"{line} --json")
        if '"ok": false' in answer:
            raise BadRequest(answer)
        return answer


class PtyBench(ProcessBench):
    """Over a pseudo-terminal: a serial line, or a serial CAN adapter and the bus behind it."""

    transport: ClassVar[str] = "pty"
    on_bus: ClassVar[bool] = True
    bus_is_checked: ClassVar[bool] = False  # the text of a serial adapter has no check

    def _door(self) -> tuple[str, str]:
        return "--slcan" if self.row.can else "--pty", str(self._home / "arm")


class TcpBench(ProcessBench):
    """Over TCP."""

    transport: ClassVar[str] = "tcp"

    def _door(self) -> tuple[str, str]:
        return "--tcp", "127.0.0.1:0"


class UdpBench(ProcessBench):
    """Over UDP: datagrams without pacing or acknowledgement."""

    transport: ClassVar[str] = "udp"

    def _door(self) -> tuple[str, str]:
        return "--udp", "127.0.0.1:0"


SLOWLY = 0.3
"""The speed of a real arm's first motion."""


def port_lock(port: str) -> FileLock:
    """Return the lock by which tests in all processes take turns on a port.

    The driver's own lock is under `ARMDRIVE_HOME`, which differs between tests.
    """
    name = hashlib.sha256(str(Path(port).resolve()).encode()).hexdigest()[:16]
    return FileLock(Path(tempfile.gettempdir()) / f"armdrive-bench-{name}.lock")


class PortBench(RealTimeBench):
    """A real arm, which has to stand in its reference posture when the first row begins."""

    transport: ClassVar[str] = "port"
    look_s: ClassVar[float] = 0.02
    simulated: ClassVar[bool] = False
    sees_motion: ClassVar[bool] = False
    _begun: ClassVar[bool] = False

    def __init__(self, dialect_name: str, port: str) -> None:
        super().__init__(dialect_name)
        self._lock = port_lock(port)
        self._lock.acquire()
        self.set_port(port)
        self._last = Motors([0] * self.row.abilities.motors)

    def end_device(self) -> None:
        """Release the port."""
        self._lock.release()

    def look(self) -> Observation:
        """Read the registers of a standing arm; of a moving arm, use the last ones."""
        if self.arm is not None:
            self._last = _read_back(self.arm, self._last)
        return Observation(
            time.monotonic(), self._last, self.tip(self._last), self.posture(self._last)[1]
        )

    def reference(self, arm: Arm) -> None:
        """Confirm the position that the last row left; for the first row, the reference posture.

        A person has brought the arm to its reference posture before the run. The arm then moves to
        where simulated arms begin: raised, and clear of the table.
        """
        self.switch_on(arm)
        trust = arm.status.trust
        if trust is Trust.RESTORED:
            arm.reference.confirm_restored()
        elif trust is Trust.UNKNOWN and not self._begun:
            arm.reference.confirm()
        else:
            raise Refused(
                f"the position is {trust.value}: bring the arm to its reference posture, and run "
                "the remaining rows"
            )
        type(self)._begun = True
        found = found_posture(arm.model.arm)
        arm.move_j(speed=SLOWLY, **{f"{name}_deg": angle for name, angle in found.deg.items()})

    def operator(self) -> Operator:
        """Raise `Refused`: no person is asked in the middle of a test."""
        raise Refused("a real arm is referenced by `armdrive home`")

    def fault(self, words: str) -> None:
        """Raise `Refused`: no fault is injected into a real arm."""
        raise Refused(f"no fault is injected into a real arm: {words}")

    def heal(self) -> None:
        """Do nothing: there are no faults."""


def _read_back(arm: Arm, last: Motors) -> Motors:
    status: Status = arm.status
    if status.state in (State.STANDBY, State.DISABLED):
        try:
            arm.parts.look()
        except ArmError:
            return last
        status = arm.status
    return status.read_back or last
