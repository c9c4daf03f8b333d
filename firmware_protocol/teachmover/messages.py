"""The messages of a TeachMover and its host, checked when they are built, and their lines.

Motor counts are half-steps: relative in `Step`, absolute registers in `Registers` and `ProgramRow`.
Building a message may raise `BadField` (a `LocalProtocolError`), decoding one may raise
`RemoteProtocolError`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import (
    LocalProtocolError,
    RemoteProtocolError,
    chosen_by_sender,
    whole,
)
from firmware_protocol.fields import (
    BYTE,
    INT16,
    INT16_MIN,
    an_instance,
    message,
    optional,
    row_of,
    whole_from,
    wrapped16,
)

# One row of the program in a TeachMover's memory, and its packing into eight words.
#
# The packing is that of the public programs which write such rows: with the six positions as
# 16-bit two's complement, L and H their low and high bytes, the words are: the step number;
# (255 - speed) * 256 + 1; L2 L1; L4 L3; L6 L5; H2 H1; H4 H3; H6 H5, each pair high byte first.


MOTORS = 6
ROW_WORDS = 8
# The fastest speed a motion may name; 0 is the slowest.
SPEED_MAX = 245
MOVE_KIND = 1
WORD_MAX = (1 << 16) - 1
_BYTE_MAX = 255


WORD = whole_from(0, WORD_MAX)
SPEED = whole_from(0, SPEED_MAX)
SIX_STEPS = row_of(INT16, MOTORS, f"{MOTORS} counts of half-steps, one a motor")


@message(number=WORD, speed=BYTE, positions=SIX_STEPS, kind=BYTE)
class ProgramRow:
    """One row of the arm's own program: absolute positions, in half-steps, and how to get there.

    `kind` is the low byte of the second word: 1 in every row that public programs write, which
    is a move. What other kinds mean is unverified; they are kept as they are, as are speeds over
    245, so that whatever a dump holds can be written back word for word. To make a row of one's
    own use `move`, which admits only the speeds of a motion. Raises `BadField`.
    """

    number: int
    speed: int
    positions: tuple[int, ...]
    kind: int = MOVE_KIND

    @classmethod
    def move(cls, number: int, speed: int, positions: tuple[int, ...]) -> ProgramRow:
        """Make a row that moves to absolute positions in half-steps, at a speed of 0 to 245."""
        return cls(number, whole("speed", speed, 0, SPEED_MAX), positions)

    @classmethod
    def from_words(cls, words: Sequence[int]) -> ProgramRow:
        """Read a row from its eight words; raises `RemoteProtocolError`.

        A word may come as unsigned or as signed 16 bit: which of them the arm prints in a dump
        is unverified, and both name the same two bytes.
        """
        if len(words) != ROW_WORDS:
            raise RemoteProtocolError(f"a program row has {ROW_WORDS} words, not {len(words)}")
        for word in words:
            if not INT16_MIN <= word <= WORD_MAX:
                raise RemoteProtocolError(f"{word} is no 16-bit word of a program row")
        number, second, *packed = (word & WORD_MAX for word in words)
        pairs = [(word & 0xFF, word >> 8) for word in packed]
        low = [byte for pair in pairs[:3] for byte in pair]
        high = [byte for pair in pairs[3:] for byte in pair]
        positions = tuple(wrapped16(h << 8 | b) for b, h in zip(low, high, strict=True))
        return cls(number, _BYTE_MAX - (second >> 8), positions, second & 0xFF)

    @property
    def words(self) -> tuple[int, ...]:
        """The eight words of this row, unsigned 16 bit."""
        raw = [position & WORD_MAX for position in self.positions]
        pairs = list(zip(raw[::2], raw[1::2], strict=True))
        return (
            self.number,
            (_BYTE_MAX - self.speed) << 8 | self.kind,
            *((second & 0xFF) << 8 | first & 0xFF for first, second in pairs),
            *((second >> 8) << 8 | first >> 8 for first, second in pairs),
        )


# The character that a command starts with. An arm can be told another one (`@ARM`), which neither
# end here uses; nor do they use `@DELAY`.
ATTENTION = "@"
REGISTER_NUMBERS = 7


class Status(IntEnum):
    """The line that answers every command."""

    FAILED = 0
    """Failed, or not understood."""
    DONE = 1
    STOPPED = 2
    """The STOP key of the pendant was pressed."""


class Key(IntEnum):
    """The pendant's keys, as `Registers` names the last one pressed."""

    NONE = 0
    TRAIN = 1
    PAUSE = 2
    GRIP = 3
    OUT = 4
    FREE = 5
    MOVE = 6
    STOP = 7
    STEP = 8
    POINT = 9
    JUMP = 10
    CLEAR = 11
    ZERO = 12
    SPEED = 13
    RUN = 14


@message(speed=SPEED, steps=SIX_STEPS, output=optional(BYTE))
class Step:
    """Move all six motors together by relative half-steps; the answer comes at the motion's end.

    `speed` is 0 (slowest) to 245 and holds for the motor with the most steps. `output`, where
    given, is written to the output byte.
    """

    name: ClassVar[str] = "STEP"
    speed: int
    steps: tuple[int, ...]
    output: int | None = None


@message()
class Read:
    """Ask for the position registers, the last key and the inputs."""

    name: ClassVar[str] = "READ"


@message()
class Reset:
    """Zero the position registers **and switch the motor current off**: the arm can sag."""

    name: ClassVar[str] = "RESET"


@message()
class Run:
    """Run the program in the arm's memory."""

    name: ClassVar[str] = "RUN"


@message()
class QDump:
    """Ask for the program in the arm's memory."""

    name: ClassVar[str] = "QDUMP"


@message(speed=optional(SPEED))
class Close:
    """Close the gripper until its switch trips; slow, and nothing stops it from the host.

    That the arm takes a speed here and in `Set` is known only from a public program that sends one.
    """

    name: ClassVar[str] = "CLOSE"
    speed: int | None = None


@message(speed=optional(SPEED))
class Set:
    """Hand control to the pendant; the answer comes when the pendant gives it back."""

    name: ClassVar[str] = "SET"
    speed: int | None = None


@message(row=an_instance(ProgramRow, "a ProgramRow"))
class QWrite:
    """Write one row of the program in the arm's memory."""

    name: ClassVar[str] = "QWRITE"
    row: ProgramRow


def _key(field: str, value: object) -> Key | int:
    key = whole(field, value, 0, _BYTE_MAX)
    return Key(key) if key <= Key.RUN else key


@message(positions=SIX_STEPS, key=_key, inputs=BYTE)
class Registers:
    """The six position registers in half-steps, the last key pressed and the input byte.

    A key that has no name stays a number, 0 to 255.
    """

    positions: tuple[int, ...]
    key: Key | int = Key.NONE
    inputs: int = 0

    @classmethod
    def from_numbers(cls, numbers: Sequence[int]) -> Registers:
        """Read the seven numbers of a register line; raises `RemoteProtocolError`."""
        if len(numbers) != REGISTER_NUMBERS:
            raise RemoteProtocolError(
                f"a register line has {REGISTER_NUMBERS} numbers, not {len(numbers)}"
            )
        word = numbers[MOTORS]
        if not 0 <= word <= WORD_MAX:
            raise RemoteProtocolError(f"{word} does not hold a key and an input byte")
        with chosen_by_sender():
            return cls(tuple(numbers[:MOTORS]), word >> 8, word & 0xFF)

    @property
    def numbers(self) -> tuple[int, ...]:
        """The seven numbers of the register line."""
        return (*self.positions, self.key << 8 | self.inputs)


Command: TypeAlias = Step | Read | Close | Reset | Set | Run | QDump | QWrite
Reply: TypeAlias = Status | Registers | ProgramRow


# Lines, one at a time, to messages and back.
#
# The host writes upper case, decimal integers, commas, and a CR at the end. The decoders accept
# what public programs write or a wire adds: spaces around numbers, a trailing comma, spaces
# instead of commas in a program row, an LF before the line, NUL bytes before a status or a
# command. None of that may change the meaning of a line: a NUL before a register line may have
# been a minus sign, so it is not accepted there.

CR = b"\r"
# Bytes that mean nothing at either end of a line.
PADDING = b" \n"
# Bytes that mean nothing before a status or a command.
NOISE = b"\0" + PADDING
# Letters of a command's name that are enough: a public program sends @STE and @CLO.
ABBREVIATED = 3

_INTEGER = re.compile(rb"-?[0-9]{1,5}")
_COMMAND = re.compile(rb"([A-Z]+)(.*)", re.DOTALL)
_COMMA = re.compile(rb" *, *")
_SPACES = re.compile(rb" *, *| +")
_STATUS_LINES = {b"%d" % status: status for status in Status}


def encode_command(command: Command) -> bytes:
    """Return the line that gives a command, with its CR."""
    match command:
        case Step(speed, steps, output):
            numbers: tuple[int | None, ...] = (speed, *steps, output)
        case Close(speed) | Set(speed):
            numbers = (speed,)
        case QWrite(row):
            numbers = row.words
        case _:
            numbers = ()
    text = ",".join(str(number) for number in numbers if number is not None)
    return f"{ATTENTION}{command.name} {text}".rstrip(" ").encode("ascii") + CR


def encode_reply(reply: Reply) -> bytes:
    """Return the line of a status, of the registers or of a program row, with its CR."""
    match reply:
        case Status():
            numbers: tuple[int, ...] = (reply,)
        case Registers():
            numbers = reply.numbers
        case ProgramRow():
            numbers = reply.words
    return b",".join(b"%d" % number for number in numbers) + CR


def decode_reply(line: bytes) -> Reply:
    """Read a line that the arm sent; raises `RemoteProtocolError`.

    One number is a status, seven are the registers, eight are a program row.
    """
    body = line.strip(PADDING)
    fields = _fields(body, _COMMA)
    if len(fields) == 1:
        loose = _fields(body, _SPACES)
        return _row(loose) if len(loose) == ROW_WORDS else _status(fields[0].lstrip(NOISE))
    if len(fields) == REGISTER_NUMBERS:
        return Registers.from_numbers(_integers(fields))
    return _row(fields)


# How many numbers may follow the name of a command, and what makes a command of them.
_COMMANDS: dict[str, tuple[range, Callable[..., Command]]] = {
    Step.name: (
        range(MOTORS + 1, MOTORS + 3),
        lambda speed, *counts: Step(speed, counts[:MOTORS], *counts[MOTORS:]),
    ),
    Close.name: (range(2), Close),
    Set.name: (range(2), Set),
    QWrite.name: (
        range(ROW_WORDS, ROW_WORDS + 1),
        lambda *words: QWrite(ProgramRow.from_words(words)),
    ),
    **{kind.name: (range(1), kind) for kind in (Read, Reset, Run, QDump)},
}


def decode_command(body: bytes) -> Command:
    """Decode a command without its attention character. Raises `RemoteProtocolError`.

    Names may be cut down to three letters. After the name there may be a comma, and a 0, as public
    programs send them (`@READ, `, `@RESET, 0`).
    """
    found = _COMMAND.fullmatch(body.rstrip(PADDING))
    if found is None:
        raise RemoteProtocolError("no command in upper case follows the attention character")
    word = found[1].decode("ascii")
    name = next((n for n in _COMMANDS if len(word) >= ABBREVIATED and n.startswith(word)), None)
    if name is None:
        raise RemoteProtocolError(f"no command is named {word[:16]}")
    counts, command = _COMMANDS[name]
    fields = _fields(found[2].strip(PADDING), _COMMA)
    if fields in ([b""], [b"", b"0"]):
        fields = []
    if len(fields) not in counts:
        raise RemoteProtocolError(f"{name} with {len(fields)} numbers after it")
    numbers = _integers(fields)
    try:
        return command(*numbers)
    except LocalProtocolError as error:  # the sender chose a value out of range
        raise RemoteProtocolError(f"{name}: {error}") from None


def _fields(text: bytes, separator: re.Pattern[bytes]) -> list[bytes]:
    """Split at the separators; one trailing comma adds no field."""
    if not text:
        return []
    fields = separator.split(text)
    return fields[:-1] if fields[-1] == b"" else fields


def _integers(fields: list[bytes]) -> tuple[int, ...]:
    for field in fields:
        if not _INTEGER.fullmatch(field):
            shown = field[:16].decode("ascii", "backslashreplace")
            raise RemoteProtocolError(f"'{shown}' is no decimal integer of up to five digits")
    return tuple(int(field) for field in fields)


def _status(field: bytes) -> Status:
    status = _STATUS_LINES.get(field)
    if status is None:
        raise RemoteProtocolError("a line of one field that is no status 0, 1 or 2")
    return status


def _row(fields: list[bytes]) -> ProgramRow:
    if len(fields) != ROW_WORDS:
        raise RemoteProtocolError(
            f"a line of {len(fields)} fields: a status has 1, the registers have "
            f"{REGISTER_NUMBERS}, a program row has {ROW_WORDS}"
        )
    return ProgramRow.from_words(_integers(fields))
