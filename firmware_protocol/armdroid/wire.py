"""Encode an Armdroid's commands and answers, and decode answers.

A command has no line end; its letter ends it. A minus sign follows its number, because the sketch
negates the accumulated value. Answers are lines with CR LF.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from firmware_protocol.armdroid.messages import (
    KEPT,
    MOTORS,
    Answer,
    ArgumentsReported,
    Clear,
    Command,
    DriveAll,
    DriveOne,
    DropArguments,
    InterfaceReported,
    OffsetsReported,
    SetSpeed,
    SpeedReported,
    Torque,
    TorqueReported,
    VersionReported,
    Welcome,
)
from firmware_protocol.errors import BadField, RemoteProtocolError

END = b"\r\n"
WELCOME = b"Welcome, Armdroid!"
_TORQUE = {True: "enabled", False: "disabled"}

_INT = rb"(-?[0-9]{1,5})"
_NAME = rb"([!-.0-~]{1,16})"


def encode_command(command: Command) -> bytes:
    """Return a command's characters."""
    match command:
        case DriveOne():
            body = f"{command.motor},{_number(command.steps)}"
        case DriveAll():
            body = ",".join(_number(steps) for steps in command.steps)
        case SetSpeed():
            body = _number(command.rpm)
        case Torque():
            body = "1" if command.on else "0"
        case Clear():
            body = ","
        case DropArguments():
            body = "," * KEPT
        case _:
            body = ""
    return f"{body}{command.letter}".encode("ascii")


def encode_answer(answer: Answer | Welcome) -> bytes:
    """Return an answer's line with its CR LF, as the sketch prints it."""
    return _text(answer).encode("ascii") + END


def decode_answer(line: bytes) -> Answer | Welcome:
    """Decode a line from the board, without its end. Raises `RemoteProtocolError`."""
    if line == WELCOME:
        return Welcome()
    for pattern, read in _READERS:
        found = pattern.fullmatch(line)
        if found is not None:
            try:
                return read([group.decode("ascii") for group in found.groups()])
            except BadField as error:  # the board chose the value
                raise RemoteProtocolError(str(error)) from None
    raise RemoteProtocolError("the line is no answer of the serial driver sketch")


def _number(value: int) -> str:
    return f"{abs(value)}-" if value < 0 else f"{value}"


def _text(answer: Answer | Welcome) -> str:
    match answer:
        case OffsetsReported():
            return "offsets = " + ",".join(str(offset) for offset in answer.offsets)
        case SpeedReported():
            return f"speed = {answer.rpm}"
        case TorqueReported():
            return f"torque = {_TORQUE[answer.on]}"
        case VersionReported(firmware, None):
            return f"version = {firmware}"
        case VersionReported(firmware, protocol):
            return f"firmware version = {firmware}/protocol = {protocol}"
        case InterfaceReported():
            return f"interface = {answer.kind}"
        case ArgumentsReported():
            numbers = (*answer.arguments, answer.accumulator)
            return "debug = " + " ".join(str(number) for number in numbers)
        case Welcome():
            return WELCOME.decode("ascii")


def _offsets(groups: list[str]) -> Answer:
    return OffsetsReported(tuple(int(group) for group in groups))


def _arguments(groups: list[str]) -> Answer:
    *arguments, accumulator = (int(group) for group in groups)
    return ArgumentsReported(tuple(arguments), accumulator)


_READERS: tuple[tuple[re.Pattern[bytes], Callable[[list[str]], Answer]], ...] = (
    (re.compile(b"offsets = " + b",".join([_INT] * MOTORS)), _offsets),
    (re.compile(b"speed = " + _INT), lambda groups: SpeedReported(int(groups[0]))),
    (
        re.compile(b"torque = (enabled|disabled)"),
        lambda groups: TorqueReported(groups[0] == _TORQUE[True]),
    ),
    (
        re.compile(b"firmware version = " + _NAME + b"/protocol = " + _NAME),
        lambda groups: VersionReported(*groups),
    ),
    (re.compile(b"version = " + _NAME), lambda groups: VersionReported(groups[0], None)),
    (re.compile(b"interface = " + _NAME), lambda groups: InterfaceReported(groups[0])),
    (re.compile(b"debug = " + b" ".join([_INT] * MOTORS)), _arguments),
)
