"""Firmware that runs as a program of this computer, as the board of a simulated arm.

    python -m tests.firmware.native ARM_FILE BOARD PROGRAM FOLDER --pty PATH

The program runs like `armdrive sim`: the arm, the wire, their faults and the console are the
simulator's, and only the controller is the real firmware. It talks over its standard input and
output, and reports its steps in shared memory (`motors.h`), where it also finds its switches.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import mmap
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.registry.arm_files import load_arm
from armdrive.sim.device import Board, SimDevice
from armdrive.sim.grbl import board_axes, motor_letters, switches, well_set_up
from armdrive.sim.grbl.hardware import Switches
from armdrive.sim.mechanics.motors import MotorDrive, SwitchState
from armdrive.sim.serving import make_server, run_device
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from firmware_protocol.grbl import keys
from kinematics.spaces import Motors
from tests.conformance.custom_arm import arm_file
from tests.conformance.real_time_bench import DeviceProcess, PtyBench

from .boards import BOARDS, NativeBoard
from .control import NoSimulator, Pace
from .grbl_setup import fluidnc_configuration, set_up, settings_for
from .measuring import Step

if sys.platform != "win32":
    import pty
    import tty

# --- The motors, in the memory that the firmware shares: the layout of motors.h ------------------

AXES = 8
LOGGED = 1 << 20
MAGIC = 0x31544F4D
STARTS_S = 5.0
"""A program that reports its steps says so within this time."""


class AxisBlock(ctypes.Structure):
    """One motor and its limit switch: `motors_axis_t`."""

    _fields_: ClassVar = [
        ("pulses", ctypes.c_int64),
        ("closes_at", ctypes.c_int64),
        ("way", ctypes.c_int32),
        ("stuck", ctypes.c_int32),
    ]
    pulses: int
    closes_at: int
    way: int
    stuck: int


class LoggedStep(ctypes.Structure):
    """One step: `motors_step_t`."""

    _fields_: ClassVar = [
        ("time_ns", ctypes.c_uint64),
        ("axis", ctypes.c_int32),
        ("direction", ctypes.c_int32),
    ]
    time_ns: int
    axis: int
    direction: int


class MotorsFile(ctypes.Structure):
    """The whole file: `motors_file_t`."""

    _fields_: ClassVar = [
        ("magic", ctypes.c_uint32),
        ("enabled", ctypes.c_uint32),
        ("time_ns", ctypes.c_uint64),
        ("logged", ctypes.c_uint64),
        ("axes", AxisBlock * AXES),
        ("log", LoggedStep * LOGGED),
    ]
    magic: int
    enabled: int
    time_ns: int
    logged: int
    axes: Sequence[AxisBlock]
    log: Sequence[LoggedStep]


def motors_in(folder: Path) -> MotorsFile:
    """Return the shared motors of a program that runs in a folder."""
    with (folder / "motors").open("a+b") as file:
        file.truncate(ctypes.sizeof(MotorsFile))
        return MotorsFile.from_buffer(mmap.mmap(file.fileno(), 0))


STILL_S = 0.1
"""Motors that made no step for this long stand."""


class FirmwareRack:
    """The pulses that the firmware has sent, as the counts of the arm's motors: a `Rack`.

    `order` gives the axis of each motor by its place among the board's axes.
    """

    def __init__(self, motors: MotorsFile, order: Sequence[int]) -> None:
        self._motors, self._order = motors, order
        self._added = (0,) * len(order)
        self._logged, self._moved_s = 0, -math.inf

    @property
    def pulses(self) -> tuple[int, ...]:
        """The pulses of each motor since the board was made."""
        return tuple(self._motors.axes[axis].pulses for axis in self._order)

    @property
    def moving(self) -> bool:
        """Whether a motor has made a step lately."""
        now_s, logged = time.monotonic(), self._motors.logged
        if logged != self._logged:
            self._logged, self._moved_s = logged, now_s
        return now_s - self._moved_s < STILL_S

    done_s = math.inf

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at this moment."""
        return tuple(a + b for a, b in zip(self.pulses, self._added, strict=True))

    def bends(self, start_s: float, end_s: float) -> Iterable[float]:
        """Return nothing: the arm is updated often enough."""
        return ()

    def settle(self, now_s: float) -> None:
        """Do nothing: only the firmware knows when a motion ends."""

    def stop(self, now_s: float) -> None:
        """Do nothing: a program without power has been ended."""

    def count(self, deltas: Sequence[int]) -> None:
        """Add steps that the firmware did not make."""
        self._added = tuple(a + b for a, b in zip(self._added, deltas, strict=True))

    def zero(self) -> None:
        """Count from zero."""
        self._added = tuple(-made for made in self.pulses)


# --- The board: a program, its pseudo-terminal, its switches -------------------------------------

POLL_S = 0.001
"""How often the program's bytes and steps are looked at."""
CHUNK = 4096
STARTS_UP_S = 0.5
"""The drivers have no current for this long after a reset: a program starts at once, no board does.
"""
STUCK = {SwitchState.FREE: -1, SwitchState.OPEN: 0, SwitchState.CLOSED: 1}


class FirmwareBoard(Board):
    """A program with firmware as the controller of an arm."""

    title: ClassVar[str] = "native firmware"
    register_range: ClassVar[tuple[int, int]] = (-(1 << 31), (1 << 31) - 1)

    def __init__(
        self,
        world: World,
        kind: NativeBoard,
        command: Sequence[str],
        folder: Path,
        order: Sequence[int],
    ) -> None:
        self._motors = motors_in(folder)
        rack = FirmwareRack(self._motors, order)
        super().__init__(world, MotorDrive(world, rack), kind.baud)
        self._rack, self._order, self._folder = rack, order, folder
        self._command = command
        self._mask = sum(1 << axis for axis in order)
        self._switches = Switches({})
        self._due_s = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._port = -1
        self._unsent = b""
        world.energised = False
        self.boot()

    def wire_switches(self, wired: Switches) -> None:
        """Connect the limit switches."""
        self._switches = wired
        self._update_switches()

    @property
    def reports_steps(self) -> bool:
        """Whether the program was linked with the glue that reports its steps."""
        end_s = time.monotonic() + STARTS_S
        while self._motors.magic != MAGIC and time.monotonic() < end_s:
            time.sleep(POLL_S)
        return self._motors.magic == MAGIC

    @property
    def busy(self) -> bool:
        """Whether motors turn: nothing else is known of the firmware."""
        return self._rack.moving

    @property
    def registers(self) -> Motors:
        """The pulses since the last start."""
        return self.drive.counts

    def receive(self, data: bytes) -> None:
        """Give the program what has arrived."""
        self._unsent += data
        self._write()

    def due_s(self) -> float:
        """Return when to look again."""
        return self._due_s

    def happen(self) -> None:
        """Exchange bytes, steps, switches and currents with the program."""
        self._due_s = time.monotonic() + POLL_S
        self._write()
        with contextlib.suppress(BlockingIOError, OSError):  # nothing there, or the program ended
            self.outgoing += os.read(self._port, CHUNK)
        self._update_switches()
        energised = self._motors.enabled & self._mask == self._mask
        energised = energised and time.monotonic() >= self._starts_s + STARTS_UP_S
        if energised and not self.world.energised:
            self.world.energised = True
        elif not energised:
            self.world.cut_current(self.now_s)

    def boot(self) -> None:
        """Start the program."""
        self._starts_s = time.monotonic()
        self._port, far_end = pty.openpty()
        tty.setraw(far_end)
        os.set_blocking(self._port, False)
        with (self._folder / "log").open("ab") as told:
            self._process = subprocess.Popen(
                self._command,
                cwd=self._folder,
                stdin=far_end,
                stdout=far_end,
                stderr=told,
                env=os.environ | {"FIRMWARE_MOTORS": str(self._folder / "motors")},
            )
        os.close(far_end)

    def forget(self) -> None:
        """End the program, as a loss of power does."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            os.close(self._port)
        self._port, self._unsent = -1, b""
        self._motors.enabled = 0

    def reset(self) -> None:
        """Restart the program; the drivers have no current until it enables them."""
        self.forget()
        self.drive.lose_power(self.now_s)
        self.boot()

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Make the switch of a motor stick, or free it."""
        switch = self._switches.by_axis.get(self._order[axis])
        if switch is not None:
            switch.state = state
        self._update_switches()

    def _write(self) -> None:
        with contextlib.suppress(BlockingIOError, OSError):
            while self._unsent:
                self._unsent = self._unsent[os.write(self._port, self._unsent) :]

    def _update_switches(self) -> None:
        """Say at which pulse each switch closes, wherever force or lost steps have left the arm."""
        for motor, axis in enumerate(self._order):
            block, switch = self._motors.axes[axis], self._switches.by_axis.get(axis)
            if switch is None:
                block.way, block.stuck = 0, -1
                continue
            block.closes_at = switch.at - self.world.motors[motor] + block.pulses
            block.way, block.stuck = switch.way, STUCK[switch.state]


def board_of(config: ArmConfig, kind: NativeBoard, program: Path, folder: Path) -> FirmwareBoard:
    """Start a program as the board of an arm, wired for it."""
    world = World(ArmBody.of_preset(config.model))
    letters = motor_letters(config)
    order = [kind.letters.index(letter) for letter in letters]
    command = (str(program.resolve()), *kind.options)
    board = FirmwareBoard(world, kind, command, folder, order)
    axes = board_axes(letters, kind.letters)
    board.wire_switches(switches(config, world, letters, axes, well_set_up(config, letters, axes)))
    return board


def main(arm: str, name: str, program: str, folder: str, _pty: str, address: str) -> int:
    """Serve the board until standard input says to end."""
    config, kind = load_arm(Path(arm)), BOARDS[name]
    assert isinstance(kind, NativeBoard)
    board = board_of(config, kind, Path(program), Path(folder))
    try:
        if not board.reports_steps:
            sys.stderr.write(f"{program} does not report its steps: link it with its glue\n")
            return 2
        server = make_server(pty=Path(address))
        sys.stdout.write(f"it speaks {kind.dialect} at {server.address}; and waits\n")
        sys.stdout.flush()
        run_device(SimDevice(board), server, sys.stdin.fileno(), partial(print, flush=True))
    finally:
        board.forget()
    return 0


# --- The bench -----------------------------------------------------------------------------------


class NativeRunner:
    """What the benches of one program share: its settings for the arm, in a folder of their own."""

    def __init__(self, board: NativeBoard, program: Path) -> None:
        if not os.access(program, os.X_OK):
            raise NoSimulator(f"{program} is no program that can be run")
        self._temporary = tempfile.TemporaryDirectory(prefix="firmware-")
        self.board, self.program = board, program
        self.pace = Pace()
        self._number = 0
        self._settings = Path(self._temporary.name) / "settings"
        self._settings.mkdir()
        try:
            with self.bench() as bench:
                bench.set_up()
                shutil.rmtree(self._settings)
                shutil.copytree(bench.folder, self._settings)
        except RuntimeError as error:
            self.close()
            raise NoSimulator(f"{program} does not run as a board: {error}") from None
        except BaseException:
            self.close()
            raise

    def folder(self) -> Path:
        """Return a folder for a program that has just been switched on, with the settings."""
        self._number += 1
        found = Path(self._temporary.name) / str(self._number)
        unwanted = shutil.ignore_patterns("motors", "log")
        shutil.copytree(self._settings, found, ignore=unwanted)
        return found

    def bench(self, _dialect: str = "") -> NativeBench:
        """Return a bench whose board has just been switched on."""
        return NativeBench(self)

    def close(self) -> None:
        """Remove the temporary files."""
        self._temporary.cleanup()


class NativeBench(PtyBench):
    """Real firmware as a program of this computer, which has just been switched on."""

    on_bus: ClassVar[bool] = False
    look_s: ClassVar[float] = 0.005
    sees_outputs: ClassVar[bool] = False

    def __init__(self, runner: NativeRunner) -> None:
        self._runner = runner
        super().__init__(runner.board.dialect)

    def set_up(self) -> None:
        """Write the settings that the arm needs."""
        values = settings_for(self.config, self._runner.board)
        if self._runner.board.configuration:
            values = {keys.REPORT: values[keys.REPORT]}
        set_up(self.device_port, values)

    def _begin(self, lines: str) -> None:
        self._serve(lines)
        self.set_port(self._sim.port)

    def _serve_arm_file(self, lines: str, *_settings: str) -> None:
        self._serve(lines)
        self.set_arm_file(lines, self._sim.port)
        self.set_up()

    def _serve(self, lines: str) -> None:
        runner, path = self._runner, self._home / "device.toml"
        path.write_text(arm_file(self.row, lines, "/dev/null"), encoding="utf-8")
        self.folder = runner.folder()
        if runner.board.configuration:
            text = fluidnc_configuration(settings_for(load_arm(path), runner.board))
            file = self.folder / runner.board.configuration
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")
        words = (str(path), runner.board.name, str(runner.program), str(self.folder))
        self._sim = DeviceProcess(("tests.firmware.native", *words), self._door(), self.row.name)
        self._motors = motors_in(self.folder)
        self._await_clock()
        self._began_s, self._began_ns = time.monotonic(), self._motors.time_ns

    def _await_clock(self) -> None:
        """Wait until the firmware tells the time: it has started."""
        end_s = time.monotonic() + STARTS_S
        while not self._motors.time_ns and time.monotonic() < end_s:
            time.sleep(POLL_S)

    def device_now_s(self) -> float:
        """Return the time by the firmware's clock."""
        return self._motors.time_ns / 1e9

    def steps_since(self, time_s: float) -> list[Step]:
        """Return the steps after a time."""
        found: list[Step] = []
        end = self._motors.logged
        for number in range(end - 1, max(end - LOGGED, 0) - 1, -1):
            step = self._motors.log[number % LOGGED]
            if step.time_ns <= time_s * 1e9:
                break
            letter = self._runner.board.letters[step.axis]
            found.append(Step(step.time_ns / 1e9, letter, step.direction))
        return found[::-1]

    def end_device(self) -> None:
        """End the program."""
        self._count_pace()
        super().end_device()

    def _count_pace(self) -> None:
        sim_s = (self._motors.time_ns - self._began_ns) / 1e9
        self._runner.pace.add(sim_s, time.monotonic() - self._began_s)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
