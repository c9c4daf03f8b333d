"""The bench runs against simulated boards; these tests need no firmware and no compiler."""

from __future__ import annotations

import json
import re
import socket
import sys
import threading

import pytest
from amounts import every_row

from armdrive.sim.bus import DrivesBoard
from armdrive.sim.faults import parse_words
from tests.conformance import rows_faults
from tests.conformance.real_time_bench import DeviceProcess
from tests.scenarios.happenings import HAPPENINGS

from . import avr_bench, report
from .boards import BOARDS, AvrBoard, Coil
from .control import commands_of
from .measuring import Stopped, stops
from .rigs import simulated
from .run import main

AXES = "XYZABC"
JOINT_MOTION = "a joint motion arrives"
SOURCE = avr_bench.SOURCE.read_text(encoding="utf-8")


def console_words(command: str) -> str:
    """Return the console command of a simulated board for a command of a control port."""
    name, *words = command.split()
    if name == "heal":
        return "fault off"
    side, effect, amount, *_ = words
    kinds = {"lose": "drop", "flip": "corrupt", "repeat": "duplicate"}
    return f"fault {kinds[effect]} {amount} from={side}"


class FakeControlPort:
    """A control port of a simulated board: uses the board's console, and answers like `avrdev`."""

    def __init__(self, device: DeviceProcess) -> None:
        self._device = device
        self.heard: list[str] = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self.address = "{}:{}".format(*self._socket.getsockname())
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def __enter__(self) -> FakeControlPort:
        return self

    def __exit__(self, *error: object) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as last:
            last.sendto(b"quit", self._socket.getsockname())
        self._thread.join()
        self._socket.close()

    def _serve(self) -> None:
        while True:
            data, asker = self._socket.recvfrom(4096)
            command = data.decode()
            if command == "quit":
                return
            self._socket.sendto(self._answer(command).encode(), asker)

    def _answer(self, command: str) -> str:
        if command != "stat":
            self.heard.append(command)
            told = self._device.say(f"{console_words(command)} --json")
            return "ok" if '"ok": false' not in told else f"error: {told}"
        state = self._device.state()
        axes = {
            letter: {"pos": at, "on": state["energised"]}
            for letter, at in zip(AXES, state["motors"], strict=True)
        }
        clock = {"cycle": 0, "hz": 1, "sim_s": 0.0, "run_s": 0.0, "resets": 0}
        return json.dumps({**clock, "powered": state["powered"], "axes": axes})


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_device_on_a_port_with_a_control_port(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(rows_faults, "IDLE_S", 0.3)  # real time, and no message is that late here
    program, door = ("armdrive", "sim", "grbl"), ("--pty", str(tmp_path / "board"))
    device = DeviceProcess(program, door, "grbl")
    with device, FakeControlPort(device) as control:
        words = ["--port", device.port, "--dialect", "grbl", "--control", control.address]
        lost = "a message to the device is lost"
        code = main([*words, "--only", lost])
    told = capsys.readouterr().out
    assert code == 0, told
    assert "1 passed, 0 FAILED" in told
    assert "wire host lose next 0 0" in control.heard


def test_rows_on_a_simulated_board(capsys):
    assert main(["--simulated", "grbl", "--only", JOINT_MOTION]) == 0
    told = capsys.readouterr().out
    assert f"{JOINT_MOTION}, and its read-back says so" in told
    assert "1 passed, 0 FAILED" in told


def test_stops_on_a_simulated_board():
    with simulated("grbl").make() as bench:
        found = list(stops(bench, rates_hz=(100.0, 9_999.0)))
    assert [(each.how, each.rate_hz) for each in found] == [("stop", 100.0), ("release", 100.0)]
    assert all(each.kept and 0 < each.pulses < 40 for each in found)
    assert report.stop_table(found).count("yes") == len(found)


def test_a_stop_beyond_its_bound_is_reported():
    late = Stopped("stop", 25.0, 30.5, 0.3, 0.43, 60.0, 1.0, 14)
    assert "NO: beyond the announced bound" in report.stop_table([late])
    lost = Stopped("stop", 25.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, "E501 off the path")
    assert "NO: E501 off the path" in report.stop_table([lost])


AVR_BOARDS = [board for board in BOARDS.values() if isinstance(board, AvrBoard)]


@every_row("board", AVR_BOARDS, ids=lambda board: board.name)
def test_the_processor_simulator_understands_the_wiring_of_every_board(board):
    options = [word for word in board.wiring if word.startswith("--")]
    assert {*options} <= {*re.findall(r'strcmp\(word, "(--[\w-]+)"\)', SOURCE)}
    wired = [motor for motor in board.motors if isinstance(motor, Coil)]
    assert len({motor.address for motor in wired}) == len(wired)
    assert bool(wired) == (board.coil_bus is not None)


@every_row(
    "words", [word for each in HAPPENINGS if each.needs is not DrivesBoard for word in each.words]
)
def test_every_fault_of_a_serial_line_is_a_command_of_the_control_port(words):
    known = set(re.findall(r'^    \{"(\w+)", \w+,', SOURCE, re.MULTILINE))
    commands = list(commands_of(parse_words(words.split()), AXES))
    assert commands
    assert {each.split()[0] for each in commands} <= known


def test_a_missing_tool_or_file_is_reported(tmp_path, capsys, monkeypatch):
    with pytest.raises(SystemExit):
        main([])
    assert "name an image" in capsys.readouterr().err
    image = tmp_path / "robko.elf"
    assert main(["--robko", str(image)]) == 2
    assert "cannot be read" in capsys.readouterr().err
    image.write_text(":100000000C9434000C9451000C9451000C945100", encoding="ascii")
    assert main(["--robko", str(image)]) == 2
    assert "no ELF file for AVR" in capsys.readouterr().err
    image.write_bytes(b"\x7fELF".ljust(18, b"\0") + avr_bench.AVR_MACHINE)
    monkeypatch.setenv("CC", sys.executable)  # any program: this computer may have no compiler
    assert main(["--robko", str(image), "--simavr", str(tmp_path)]) == 2
    assert "no sim_avr.h" in capsys.readouterr().err
    monkeypatch.delenv("CC")
    monkeypatch.setattr(avr_bench.shutil, "which", lambda _: None)
    assert main(["--robko", str(image)]) == 2
    assert "C compiler" in capsys.readouterr().err
