"""A bench of a processor that is simulated with its image: its simulator, and its arm."""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from armdrive.arm import Arm
from armdrive.connect.target import simulated_config
from armdrive.registry import simulated_kind
from armdrive.sim.faults import parse_words
from armdrive.sim.grbl import switches
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from kinematics import Motors
from tests.conformance.custom_arm import measured_lines
from tests.conformance.observation import Observation
from tests.conformance.real_time_bench import RealTimeBench, port_lock

from .boards import AvrBoard
from .control import ControlPort, NoSimulator, Pace, PhysicalState
from .grbl_setup import set_up, settings_for
from .measuring import Step, StepLog

SOURCE = Path(__file__).with_name("avrdev.c")
AVR_MACHINE = (83).to_bytes(2, "little")
"""What the header of an ELF file has for AVR."""
COMPILES_S = 120.0
ENDS_S = 10.0
STARTS_S = 1.0
"""Firmware has written its factory settings into an empty EEPROM by then, by its own clock."""
POLL_S = 0.01


def check_image(image: Path) -> None:
    """Raise `NoSimulator` unless a file looks like an image for an AVR processor."""
    try:
        with image.open("rb") as file:
            head = file.read(20)
    except OSError as error:
        raise NoSimulator(f"{image} cannot be read: {error.strerror}") from None
    if head[:4] != b"\x7fELF" or head[18:] != AVR_MACHINE:
        raise NoSimulator(f"{image} is no ELF file for AVR: name that one, not a .hex file")


def compile_avrdev(target: Path, simavr: Path | None = None) -> Path:
    """Compile the simulator against the simavr that pkg-config finds, or the one in a folder."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise NoSimulator("there is no C compiler: install one, or name it in CC")
    flags = _flags_of_folder(simavr) if simavr is not None else _flags_of_package()
    command = [compiler, "-O2", "-o", str(target), str(SOURCE), *flags, "-lelf", "-lutil", "-lm"]
    made = subprocess.run(command, capture_output=True, text=True, timeout=COMPILES_S, check=False)
    if made.returncode:
        raise NoSimulator(f"{shlex.join(command)} failed:\n{made.stderr}")
    return target


def _flags_of_package() -> list[str]:
    found = (
        subprocess.run(
            ["pkg-config", "--cflags", "--libs", "simavr"],
            capture_output=True,
            text=True,
            check=False,
        )
        if shutil.which("pkg-config")
        else None
    )
    if found is None or found.returncode:
        raise NoSimulator(
            "pkg-config finds no simavr: install libsimavr-dev and libelf-dev, point "
            "PKG_CONFIG_PATH at another one, or name its folder with --simavr"
        )
    return shlex.split(found.stdout)


def _flags_of_folder(folder: Path) -> list[str]:
    """Return the flags for a simavr checkout that is built but not installed."""
    header = next(iter(sorted(folder.rglob("sim_avr.h"))), None)
    library = next(
        (each for name in ("libsimavr.a", "libsimavr.so") for each in sorted(folder.rglob(name))),
        None,
    )
    if header is None or library is None:
        raise NoSimulator(f"there is no sim_avr.h with a libsimavr.a or libsimavr.so in {folder}")
    return [
        f"-I{header.parent}",
        str(library),
        f"-Wl,-rpath,{library.parent.resolve()}",
        "-lpthread",
    ]


class AvrProcess:
    """A running image. `port` is its serial port, `control_port` its UDP port."""

    def __init__(self, program: Path, image: Path, tty: Path, options: Sequence[str]) -> None:
        log = tty.with_suffix(".log")
        with log.open("w", encoding="utf-8") as told:
            self._process = subprocess.Popen(
                [str(program), str(image), "--tty", str(tty), "--until-eof", *options],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=told,
                text=True,
            )
        assert self._process.stdout is not None
        # some versions of simavr print to standard output
        told = (line for line in self._process.stdout if line.startswith("ready "))
        ready = next(told, "").split()
        if not ready:
            self.end()
            raise NoSimulator(f"{image} does not run: {log.read_text(encoding='utf-8').strip()}")
        _, self.port, port = ready
        self.control_port = int(port)

    def end(self) -> None:
        """End the process by closing its input."""
        with contextlib.suppress(BrokenPipeError):
            try:
                self._process.communicate(timeout=ENDS_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.communicate()


PLUGGED_S = 5.0
"""How long a device may take to appear under the name of another port."""


class ControlledBench(RealTimeBench):
    """A device on a port; a control port reports its motors and injects its faults."""

    transport: ClassVar[str] = "pty"
    look_s: ClassVar[float] = 0.01
    sees_outputs: ClassVar[bool] = False

    def __init__(
        self, dialect_name: str, port: str, control: ControlPort, letters: str, pace: Pace
    ) -> None:
        super().__init__(dialect_name)
        self.control, self.letters = control, letters
        self._pace, self._begun = pace, control.look()
        self._lock = port_lock(port)
        self._lock.acquire()
        self.set_port(port)

    @property
    def board(self) -> type:
        """The class of the simulated board, which has the same abilities as the real one."""
        return simulated_kind(self.row.name).board

    def look(self) -> Observation:
        """Ask the control port for the physical state."""
        state = self.control.look()
        motors = self._motors(state)
        opening_mm = self.posture(motors)[1]
        held = state.energised or not self.sees_current
        return Observation(
            time.monotonic(), motors, self.tip(motors), opening_mm, held, state.powered
        )

    def _motors(self, state: PhysicalState) -> Motors:
        # a board may have fewer axes than the arm has motors, or one for fingers on a servo
        count = len(self.transmission.motors)
        turned = [state.positions[letter] for letter in self.letters[:count]]
        return Motors([*turned, *[0] * (count - len(turned))])

    def fault(self, words: str) -> None:
        """Inject a fault of the simulator's table, now or later. Raises `BadRequest`."""
        request = parse_words(words.split())
        if request.after_s:
            self.call_later(request.after_s, lambda: self.control.fault(request, self.letters))
        else:
            self.control.fault(request, self.letters)

    def heal(self) -> None:
        """Undo every fault."""
        self.control.heal()
        self._await_port(self.device_port)

    def replug_elsewhere(self) -> None:
        """Put the cable back under another name, which the arm file then names, if there is one."""
        there = str(self._home / "elsewhere")
        self.control.replug(there)
        if self.port == self.device_port:
            self.set_port(there)
        else:
            self.set_arm_file("", there)
        self._await_port(there)

    def _await_port(self, port: str) -> None:
        """Wait until the simulator has made its port."""
        end_s = time.monotonic() + PLUGGED_S
        while not Path(port).exists() and time.monotonic() < end_s:
            time.sleep(self.look_s)

    def end_device(self) -> None:
        """Release the port."""
        before, after = self._begun, self.control.look()
        self._pace.add(after.sim_s - before.sim_s, after.run_s - before.run_s)
        self.control.close()
        self._lock.release()


class ImageRunner:
    """What the benches of one image share: the compiled simulator and a configured EEPROM."""

    def __init__(self, board: AvrBoard, image: Path, simavr: Path | None = None) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="firmware-")
        self.folder = Path(self._folder.name)
        self.board, self.image = board, image
        self.pace = Pace()
        self.log = StepLog(self.folder / "steps.csv", board.hz)
        self._set_up_eeprom = self.folder / "eeprom"
        try:
            check_image(image)
            self.program = compile_avrdev(self.folder / "avrdev", simavr)
            if board.dialect == "grbl":
                self._set_up()
        except BaseException:
            self.close()
            raise

    def start(self) -> AvrProcess:
        """Start the board with the settings that the arm needs."""
        eeprom = self.folder / "eeprom-in-use"
        if self._set_up_eeprom.exists():
            shutil.copy(self._set_up_eeprom, eeprom)
        return self._start(eeprom)

    def _start(self, eeprom: Path) -> AvrProcess:
        options = ["--eeprom", str(eeprom), "--step-log", str(self.log.path)]
        return AvrProcess(
            self.program, self.image, self.folder / "tty", [*self.board.wiring, *options]
        )

    def bench(self, _dialect: str = "") -> AvrBench:
        """Return a bench whose board has just been switched on."""
        return AvrBench(self)

    def close(self) -> None:
        """Remove the temporary files."""
        self._folder.cleanup()

    def _set_up(self) -> None:
        """Write the settings that the arm needs; the EEPROM keeps them for every bench."""
        process = self._start(self._set_up_eeprom)
        try:
            self._await_factory_settings(process)
            config = simulated_config(self.board.dialect)
            set_up(process.port, settings_for(config, self.board))
        finally:
            process.end()

    def _await_factory_settings(self, process: AvrProcess) -> None:
        """Wait before the port is opened: the reset would leave half of them unwritten."""
        control = ControlPort("127.0.0.1", process.control_port)
        try:
            while control.look().time_s < STARTS_S:
                time.sleep(POLL_S)
        finally:
            control.close()


class AvrBench(ControlledBench):
    """Real firmware in a processor simulator, which has just been switched on."""

    def __init__(self, runner: ImageRunner) -> None:
        self._log, self._process = runner.log, runner.start()
        self._runner = runner
        control = ControlPort("127.0.0.1", self._process.control_port)
        letters = runner.board.letters
        super().__init__(runner.board.dialect, self._process.port, control, letters, runner.pace)
        if not self.config.model.verified:
            self.set_arm_file("", self.device_port)
        found = World(ArmBody.of_preset(self.config.model)).motors
        control.place(letters, Motors(found[: len(letters)]))

    def set_arm_file(self, lines: str, port: str) -> None:
        """Make drivers open an arm file of a measured arm with more lines."""
        super().set_arm_file(f"{lines}\n{measured_lines(self.row)}", port)

    def use_arm_file(self, lines: str) -> None:
        """Use an arm file with more lines, and configure the board for it."""
        self.disconnect()
        self.set_arm_file(lines, self.device_port)
        if self.row.name != "grbl":
            return
        values = settings_for(self.config, self._runner.board)
        set_up(self.device_port, values)
        if self.config.homing is not None:
            world = World(ArmBody.of_preset(self.config.model))
            wired = switches(self.config, world, self.letters, self.letters, values)
            for letter, switch in zip(self.letters, wired.by_axis.values(), strict=True):
                self.control.switch_at(letter, switch.at, switch.way)

    def reference(self, arm: Arm) -> None:
        """Reference the arm, after its motors stand where the board counts them.

        Robko's board energises its motors with their first step only.
        """
        if self.settles_steps:
            self.switch_on(arm)
            for way in (1, -1):
                arm.move_motors(*(way,) * arm.abilities.motors)
        super().reference(arm)

    @property
    def settles_steps(self) -> int:
        """How far a motor may turn when its current comes on after a restart.

        A board that drives coils begins with its first coil pattern, whichever the motor stands at.
        """
        return 0 if self._runner.board.coil_bus is None else 2

    @property
    def sees_current(self) -> bool:
        """Whether the pins show the motor current."""
        return self._runner.board.tells_current

    def device_now_s(self) -> float:
        """Return the time by the processor's clock."""
        return self.control.look().time_s

    def steps_since(self, time_s: float) -> list[Step]:
        """Return the steps after a time."""
        self.control.flush()
        return self._log.since(time_s)

    def end_device(self) -> None:
        """End the simulator."""
        super().end_device()
        self._process.end()
