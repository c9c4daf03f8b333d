"""What a TeachMover and its host say, in sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.dialects.words import moved, plain, standing
from firmware_protocol.teachmover.messages import (
    Arm,
    Close,
    Key,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Set,
    Status,
    Step,
)
from firmware_protocol.teachmover.program import MOVE_KIND, ProgramRow

MOTORS = ("base", "shoulder", "elbow", "right wrist", "left wrist", "gripper")
"""In the order of `@STEP` and `@READ`."""

_STATUS: Mapping[Status, str] = MappingProxyType(
    {
        Status.FAILED: "failed, or not understood",
        Status.DONE: "done",
        Status.STOPPED: "the pendant's STOP key was pressed",
    }
)


def _step(message: Step) -> str:
    output = "" if message.output is None else f"; outputs {message.output}"
    return f"step at speed {message.speed}: {moved(MOTORS, message.steps)}{output}"


def _registers(message: Registers) -> str:
    pressed = f"; last key {plain(message.key)}" if message.key != Key.NONE else ""
    inputs = f"; inputs {message.inputs}" if message.inputs else ""
    return f"registers: {standing(MOTORS, message.positions)}{pressed}{inputs}"


def _row(row: ProgramRow) -> str:
    if row.kind != MOVE_KIND:
        return f"row {row.number}, of the unknown kind {row.kind}"
    return f"row {row.number}, at speed {row.speed} to {standing(MOTORS, row.positions)}"


def _at_speed(message: Close | Set) -> str:
    return "" if message.speed is None else f" at speed {message.speed}"


SENTENCES: Mapping[type, Callable[[Any], str]] = MappingProxyType(
    {
        Status: _STATUS.__getitem__,
        Step: _step,
        Registers: _registers,
        Read: lambda _: "read the registers",
        Reset: lambda _: "zero the registers and switch the motors off",
        Close: lambda message: f"close the gripper until its switch trips{_at_speed(message)}",
        Set: lambda message: f"give control to the pendant{_at_speed(message)}",
        Arm: lambda message: f"begin commands with {message.attention} from now on",
        QDump: lambda _: "tell the arm's own program",
        QWrite: lambda message: f"write into the arm's own program: {_row(message.row)}",
        ProgramRow: _row,
    }
)
