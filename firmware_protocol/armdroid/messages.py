"""Commands and answers of the Armdroid's serial driver sketch; fields are checked when built.

Source: Armdroid/Armdroid-Arduino-Library, examples/SerialDriver/SerialDriver.ino (firmware 2.0,
protocol 1.0a) and Armdroid.cpp. Counts are whole motor steps, 48 per turn, as signed 16-bit
numbers, like the sketch's on an AVR board. Invalid values raise `BadField`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import BadField, RemoteProtocolError, chosen_by_sender
from firmware_protocol.fields import BYTE, INT16, boolean, message, optional, row_of

# 1 gripper, 2 left wrist, 3 right wrist, 4 elbow, 5 shoulder, 6 base.
MOTORS = 6
KEPT = MOTORS - 1  # arguments that the sketch keeps; the sixth number is its accumulator
STEPS_PER_TURN = 48
RPM_DEFAULT = 100  # the speed after a start of the board
# One step per millisecond. Above it the sketch steps as fast as it can; at 0 it divides by zero.
RPM_MAX = 60 * 1000 // STEPS_PER_TURN

SIX_STEPS = row_of(INT16, MOTORS, f"{MOTORS} counts of steps")


@message(motor=BYTE, steps=INT16)
class DriveOne:
    """Move one motor by relative steps; the answer comes at the motion's end.

    If there is no such motor, the board moves nothing and answers.

    The board keeps the arguments: the first becomes the motor's number, and the others remain from
    the last `DriveAll`. If another program later sends a `D`, motors 1 to 5 move by these numbers.
    `DropArguments` clears them.
    """

    letter: ClassVar[str] = "d"
    motor: int
    steps: int


@message(steps=SIX_STEPS)
class DriveAll:
    """Move all six motors together by relative steps, each at the same rate until it is done.

    The host always sends all six numbers, so that kept arguments do not matter. The board keeps the
    first five: the letter `D` alone, as in the text `@READ`, moves motors 1 to 5 once more.
    `DropArguments` clears them.
    """

    letter: ClassVar[str] = "D"
    steps: tuple[int, ...]


@message()
class HomeToOffsets:
    """Drive all motors back to offset zero, the whole way; nothing stops it."""

    letter: ClassVar[str] = "h"


@message()
class ReportOffsets:
    """Ask for the six offsets."""

    letter: ClassVar[str] = "o"


@message()
class ZeroOffsets:
    """Set the offsets to zero here; the board clears its accumulator and arguments too."""

    letter: ClassVar[str] = "r"


@message(rpm=INT16)
class SetSpeed:
    """Set the speed of later motions; a host sends 1 to `RPM_MAX`.

    The board waits a whole number of milliseconds between steps, so many speeds are equivalent. At
    0 it divides by zero; on an AVR, later motions then never end. Below 0 and above `RPM_MAX` it
    steps as fast as it can.
    """

    letter: ClassVar[str] = "s"
    rpm: int


@message(on=boolean)
class Torque:
    """Switch the motor current on or off; off lets the arm sag."""

    letter: ClassVar[str] = "t"
    on: bool


@message()
class Version:
    """Ask for the versions of the firmware and the protocol."""

    letter: ClassVar[str] = "v"


@message()
class ReportArguments:
    """Ask for the kept arguments and the accumulator (the sketch's own debugging command)."""

    letter: ClassVar[str] = "g"


@message()
class Clear:
    """Reset the accumulator and the argument index from any state; moves nothing.

    A comma removes a left-over number from the accumulator, and a `d` of 0 steps resets the index.
    Otherwise numbers that another program sent without a letter would become part of the next
    motion. Send this first in a session, and first after `give_up`.
    """

    letter: ClassVar[str] = "d"


@message()
class DropArguments:
    """Set the kept arguments to zero, so that a stray `D` moves nothing; moves nothing itself.

    Valid only after `Clear` or a drive: with any other index, the last comma would write past the
    end of the sketch's array of five.
    """

    letter: ClassVar[str] = "d"


Command: TypeAlias = (
    DriveOne
    | DriveAll
    | HomeToOffsets
    | ReportOffsets
    | ZeroOffsets
    | SetSpeed
    | Torque
    | Version
    | ReportArguments
    | Clear
    | DropArguments
)

# A device's input: `Clear` and `DropArguments` arrive as `DriveOne` that moves nothing.
Request: TypeAlias = Command


# The answers.

_WORD = re.compile(r"[!-.0-~]{1,16}")


def _word(field: str, value: object) -> str:
    if not isinstance(value, str) or not _WORD.fullmatch(value):
        raise BadField(field, value, "1 to 16 printable ASCII characters, no space and no slash")
    return value


@message(offsets=SIX_STEPS)
class OffsetsReported:
    """The motors' positions, in steps from where the offsets were zeroed; they wrap at 16 bits."""

    offsets: tuple[int, ...]


@message(rpm=INT16)
class SpeedReported:
    """The number that the board took for the speed."""

    rpm: int


@message(on=boolean)
class TorqueReported:
    """Whether the motor current is on now."""

    on: bool


@message(firmware=_word, protocol=optional(_word))
class VersionReported:
    """The versions; sketches up to 1.3 report only the firmware's, so `protocol` is None."""

    firmware: str = "2.0"
    protocol: str | None = "1.0a"


@message(arguments=row_of(INT16, KEPT, f"{KEPT} counts of steps"), accumulator=INT16)
class ArgumentsReported:
    """The five kept arguments and the accumulator."""

    arguments: tuple[int, ...]
    accumulator: int


@message()
class Welcome:
    """The greeting of a board with native USB when its port is opened; its arguments are cleared.

    The board carries out commands sent before the greeting after it.
    """


Answer: TypeAlias = (
    OffsetsReported | SpeedReported | TorqueReported | VersionReported | ArgumentsReported
)

# The answer to each command letter. The sketch also has V, which asks for the kind of motor
# interface and which no program here sends; it ignores all other letters.
ANSWER_TO: dict[str, type[Answer]] = {
    "d": OffsetsReported,
    "D": OffsetsReported,
    "h": OffsetsReported,
    "o": OffsetsReported,
    "r": OffsetsReported,
    "s": SpeedReported,
    "t": TorqueReported,
    "v": VersionReported,
    "g": ArgumentsReported,
}


# The characters of commands and answers.
#
# A command has no line end; its letter ends it. A minus sign follows its number, because the sketch
# negates the accumulated value. Answers are lines with CR LF.

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
            with chosen_by_sender():
                return read([group.decode("ascii") for group in found.groups()])
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
    (re.compile(b"debug = " + b" ".join([_INT] * MOTORS)), _arguments),
)
