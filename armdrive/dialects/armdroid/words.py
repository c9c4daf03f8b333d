"""Descriptions of Armdroid messages in words, and recognition of an Armdroid.

Commands have no line ends; each ends with its letter.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
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
from armdrive.dialects.words import (
    AnswerLines,
    Describer,
    Message,
    Sentences,
    Weight,
    moved,
    standing,
)
from firmware_protocol.armdroid import Version
from firmware_protocol.armdroid.messages import (
    ArgumentsReported,
    OffsetsReported,
    SpeedReported,
    TorqueReported,
    VersionReported,
    Welcome,
    decode_answer,
    encode_command,
)

# In the sketch's order.
MOTORS = ("gripper", "left wrist", "right wrist", "elbow", "shoulder", "base")

SENTENCES: Sentences = MappingProxyType(
    {
        OffsetsReported: lambda message: f"offsets: {standing(MOTORS, message.offsets)}",
        SpeedReported: lambda message: f"the speed is {message.rpm} rpm",
        TorqueReported: lambda message: f"the motors are {'on' if message.on else 'off'}",
        VersionReported: lambda message: (
            f"firmware {message.firmware}, protocol {message.protocol or 'unknown'}"
        ),
        ArgumentsReported: lambda message: (
            f"stored numbers: {standing(MOTORS, (*message.arguments, message.accumulator))}"
        ),
        Welcome: lambda _: "the board's greeting",
    }
)

_COMMAND = re.compile(r"([0-9,-]*)([A-Za-z])")


def commands(data: bytes) -> str:
    """Describe the commands in bytes that a host sends."""
    text = data.decode("latin-1")
    told = [_command(_numbers(digits), letter) for digits, letter in _COMMAND.findall(text)]
    return "; ".join(told)


def _numbers(digits: str) -> tuple[int, ...]:
    """Return the numbers before a letter; a minus sign follows its number."""
    found = re.findall(r"([0-9]{1,6})(-?)", digits)
    return tuple(-int(number) if sign else int(number) for number, sign in found)


def _command(numbers: tuple[int, ...], letter: str) -> str:
    known = _LETTERS.get(letter)
    return f"{letter}: no command of the sketch" if known is None else known(numbers)


def _drive_one(numbers: tuple[int, ...]) -> str:
    if len(numbers) < 2:
        return "clear the stored numbers"
    motor, steps = numbers[:2]
    name = MOTORS[motor - 1] if 1 <= motor <= len(MOTORS) else f"motor {motor}"
    return f"move the {name} by {steps:+d}"


def _drive_all(numbers: tuple[int, ...]) -> str:
    return f"move: {moved(MOTORS, numbers)}" if numbers else "move by the stored numbers"


def _report(numbers: tuple[int, ...]) -> str:
    if not numbers:
        return "read back the stored numbers"
    return f"store these numbers and read them back: {moved(MOTORS, numbers)}"


def _speed(numbers: tuple[int, ...]) -> str:
    return f"set the speed to {numbers[-1]} rpm" if numbers else "set the speed"


_LETTERS: Mapping[str, Callable[[tuple[int, ...]], str]] = MappingProxyType(
    {
        "d": _drive_one,
        "D": _drive_all,
        "g": _report,
        "s": _speed,
        "h": lambda _: "drive all motors back to offset zero",
        "o": lambda _: "read the offsets",
        "r": lambda _: "call this position zero",
        "t": lambda numbers: f"switch the motors {'on' if any(numbers) else 'off'}",
        "v": lambda _: "ask for the versions",
        "V": lambda _: "ask for the interface to the motors",
    }
)


def _weighed(line: bytes) -> Message:
    if line.startswith(b"Welcome"):
        return Message(line, Weight.BANNER)
    own = line.startswith((b"firmware", b"version", b"interface"))
    return Message(line, Weight.SELF if own else Weight.ANSWER)


TALK = Describer(
    lambda: AnswerLines(b"\r\n", _weighed), decode_answer, commands, sentences=SENTENCES
)


# An Armdroid is recognised by any answer of its sketch.

_VERSION = encode_command(Version())


def _sign(received: bytes) -> Identity | None:
    firmware, greeted, seen = "", False, False
    for answer in decoded(received, b"\r\n", decode_answer):
        seen |= answer is not None
        if isinstance(answer, VersionReported):
            spoken = f", protocol {answer.protocol}" if answer.protocol else ""
            firmware = f"Armdroid serial driver {answer.firmware}{spoken}"
        greeted |= isinstance(answer, Welcome)
    found = Identity("armdroid", firmware or "Armdroid serial driver", greeted)
    return found if seen else None


RECOGNITION = Recognition(
    _sign,
    Certainty.WORDED,
    # the CR completes the line on a board of another dialect
    (Probe("v", _VERSION + b"\r", 0.5, risk=Risk.LINE_END),),
    obeys_letters=True,
    greets_on_open=True,
)

TOOLS = DeviceTools(TALK, RECOGNITION)
