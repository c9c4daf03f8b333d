"""Describe the messages of a TeachMover and its host in words, and recognise a TeachMover."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from armdrive.dialects import DeviceTools
from armdrive.dialects.recognition import (
    Certainty,
    Identity,
    Probe,
    Recognition,
    Risk,
    decoded,
)
from armdrive.dialects.teachmover.controller import HARMLESS, HARMLESS_LINE
from armdrive.dialects.teachmover.pendant import PendantProgram
from armdrive.dialects.words import (
    AnswerLines,
    Describer,
    Sentences,
    answer,
    moved,
    plain,
    standing,
)
from firmware_protocol.teachmover.messages import (
    MOVE_KIND,
    Close,
    Key,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Set,
    Status,
    Step,
    decode_command,
    decode_reply,
    encode_command,
)

# The motors' names in the order of `@STEP` and `@READ`.
MOTORS = ("base", "shoulder", "elbow", "right wrist", "left wrist", "gripper")

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


SENTENCES: Sentences = MappingProxyType(
    {
        Status: _STATUS.__getitem__,
        Step: _step,
        Registers: _registers,
        Read: lambda _: "read the registers",
        Reset: lambda _: "zero the registers and switch the motors off",
        Close: lambda message: f"close the gripper until its switch trips{_at_speed(message)}",
        Set: lambda message: f"give control to the pendant{_at_speed(message)}",
        QDump: lambda _: "send the arm's own program",
        QWrite: lambda message: f"write into the arm's own program: {_row(message.row)}",
        ProgramRow: _row,
    }
)


def _sent(data: bytes) -> object:
    if data == HARMLESS_LINE:
        return "moves nothing, and makes an Armdroid harmless that was taken for a TeachMover"
    return decode_command(data.strip().lstrip(b"@"))


TALK = Describer(lambda: AnswerLines(b"\r\n", answer), decode_reply, _sent, sentences=SENTENCES)


# Recognise a TeachMover by its registers directly after a status line.


def _sign(received: bytes) -> Identity | None:
    """Recognise seven numbers as a TeachMover's registers only after a status line."""
    before: object = None
    for reply in decoded(received, b"\r", decode_reply):
        if isinstance(reply, Registers):
            if before is Status.DONE:
                return Identity("teachmover", "TeachMover")
            return Identity(
                "",
                "Robko 01 retrofit, in its text mode",
                remedy="switch the retrofit to its SUPER protocol, which is the dialect robko01",
            )
        before = reply
    return None


RECOGNITION = Recognition(
    _sign,
    Certainty.BARE,
    (
        # sent late: an Armdroid that was too busy to answer has no motion to repeat after this
        Probe(HARMLESS, HARMLESS_LINE, 0.5, risk=Risk.SETTINGS),
        Probe("@READ", encode_command(Read()), 1.0, risk=Risk.MOTION, after=HARMLESS),
    ),
)

TOOLS = DeviceTools(TALK, RECOGNITION, pendant=PendantProgram)
