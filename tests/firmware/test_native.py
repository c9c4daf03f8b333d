"""A program as a simulated arm's board, without any firmware: `cat` takes its place."""

from __future__ import annotations

import ctypes
import re
import select
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from armdrive.connect.target import simulated_config
from armdrive.sim.device import SimDevice
from armdrive.sim.mechanics.motors import SwitchState

from . import native
from .boards import GRBLHAL
from .native import AXES, LOGGED, MAGIC, FirmwareBoard, board_of, motors_in
from .run import main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
ECHOES_S = 10.0
HEADER = (Path(native.__file__).with_name("motors.h")).read_text(encoding="utf-8")


@pytest.fixture
def board(tmp_path):
    cat = Path("/bin/cat")
    made = board_of(simulated_config("grbl"), replace(GRBLHAL, options=()), cat, tmp_path)
    yield made
    made.forget()


def echoed(board: FirmwareBoard) -> bytes:
    """Return what the program has sent."""
    select.select([board._port], [], [], ECHOES_S)
    board.happen()
    sent = bytes(board.outgoing)
    board.outgoing.clear()
    return sent


def test_the_layout_is_that_of_the_header():
    assert f"#define MOTORS_MAGIC {MAGIC:#x}u" in HEADER
    assert re.search(r"#define MOTORS_AXES (\d+)", HEADER)[1] == str(AXES)
    assert f"#define MOTORS_LOGGED (1u << {LOGGED.bit_length() - 1})" in HEADER
    fields = re.findall(r"volatile \w+ (\w+);", HEADER)
    of_axis = [name for name, _ in native.AxisBlock._fields_]
    of_file = [name for name, _ in native.MotorsFile._fields_]
    assert fields == [*of_axis, *of_file[1:4]]
    assert ctypes.sizeof(native.AxisBlock) == 24


def test_bytes_pass_through_a_program_and_a_reset_starts_another(board):
    board.receive(b"G91\xff\x18\n")
    assert echoed(board) == b"G91\xff\x18\n"
    first = board._process
    board.reset()
    assert first.poll() is not None
    board.receive(b"?")
    assert echoed(board) == b"?"


def test_pulses_turn_the_arm_and_close_switches_wherever_it_was_pushed(board, tmp_path):
    motors, device = motors_in(tmp_path), SimDevice(board)
    began = board.world.motors
    motors.axes[2].pulses, motors.logged = 7, 7
    board.drive.follow(1.0)
    third = [0, 0, 7, 0, 0, 0]
    assert list(board.world.motors - began) == third
    assert list(board.registers) == third
    left = motors.axes[2].closes_at - 7
    device.push([0, 0, -5, 0, 0, 0])
    board.happen()
    assert motors.axes[2].closes_at - 7 == left + 5
    board.set_switch(2, SwitchState.CLOSED)
    assert [motors.axes[axis].stuck for axis in (1, 2)] == [-1, 1]


def test_the_current_is_that_of_all_motors(board, tmp_path, monkeypatch):
    monkeypatch.setattr(native, "STARTS_UP_S", 0.0)
    motors = motors_in(tmp_path)
    for enabled, held in ((0b011111, False), (0b111111, True), (0, False)):
        motors.enabled = enabled
        board.happen()
        assert board.world.energised is held


def test_a_program_without_glue_or_that_cannot_run_is_told_of(board, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(native, "STARTS_S", 0.0)
    assert not board.reports_steps
    motors_in(tmp_path).magic = MAGIC
    assert board.reports_steps
    assert main(["--grblhal", str(tmp_path / "no")]) == 2
    assert "no program that can be run" in capsys.readouterr().err
