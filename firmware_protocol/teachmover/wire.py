"""The TeachMover's lines: commands and replies to bytes and back, one line at a time.

Written as the arm's users write them: upper case, decimal integers, commas, CR alone at the end.
Read with these liberties, each of them taken by some public program or by the wires:
spaces around numbers, a trailing comma, spaces instead of commas in a program row, a LF left
over from before the line, NUL bytes before a status or a command. Where a liberty could change
what a line means it is not taken: a NUL before a register line could have been a minus sign.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.teachmover.messages import (
    MOTORS,
    REGISTER_NUMBERS,
    ROW_WORDS,
    Arm,
    Close,
    Command,
    Delay,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reply,
    Reset,
    Run,
    Set,
    Status,
    Step,
)

CR = b"\r"
PADDING = b" \n"
"""Bytes that mean nothing at either end of a line."""
NOISE = b"\0" + PADDING
"""Bytes that mean nothing before a status or a command."""
ABBREVIATED = 3
"""Letters of a command's name that are enough: a public program sends @STE and @CLO."""

_INTEGER = re.compile(rb"-?[0-9]{1,5}")
_COMMAND = re.compile(rb"([A-Z]+)(.*)", re.DOTALL)
_COMMA = re.compile(rb" *, *")
_SPACES = re.compile(rb" *, *| +")
_STATUS_LINES = {b"%d" % status: status for status in Status}


def encode_command(command: Command, attention: str) -> bytes:
    """Return the line that gives a command, with its CR."""
    arguments = ",".join(str(argument) for argument in command.arguments)
    return f"{attention}{command.name} {arguments}".rstrip(" ").encode("ascii") + CR


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


def decode_command(body: bytes) -> Command:
    """Read a command from what stands behind the attention character.

    Raises `RemoteProtocolError`. Names may be cut down to three letters. What follows a command
    that takes nothing more may be empty or 0, as public programs send it (`@READ, `,
    `@RESET, 0`).
    """
    found = _COMMAND.fullmatch(body.rstrip(PADDING))
    if found is None:
        raise RemoteProtocolError("no command in upper case follows the attention character")
    word = found[1].decode("ascii")
    name = next((n for n in _READERS if len(word) >= ABBREVIATED and n.startswith(word)), None)
    if name is None:
        raise RemoteProtocolError(f"no command is named {word[:16]}")
    try:
        return _READERS[name](_fields(found[2].strip(PADDING), _COMMA))
    except LocalProtocolError as error:  # a field out of range, but it was not we who chose it
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


def _step(fields: list[bytes]) -> Step:
    speed, *counts = _counted(fields, 1 + MOTORS, 1 + MOTORS + 1)
    return Step(speed, tuple(counts[:MOTORS]), counts[MOTORS] if len(counts) > MOTORS else None)


def _qwrite(fields: list[bytes]) -> QWrite:
    return QWrite(ProgramRow.from_words(_counted(fields, ROW_WORDS, ROW_WORDS)))


def _delay(fields: list[bytes]) -> Delay:
    return Delay(*_counted(fields, 1, 1))


def _arm(fields: list[bytes]) -> Arm:
    if len(fields) != 1:
        raise RemoteProtocolError("ARM takes one character")
    return Arm(fields[0].decode("latin-1"))


def _counted(fields: list[bytes], least: int, most: int) -> tuple[int, ...]:
    """Read integers where their number fits."""
    if not least <= len(fields) <= most:
        wanted = f"{least}" if least == most else f"{least} or {most}"
        raise RemoteProtocolError(f"{len(fields)} numbers follow the name where {wanted} belong")
    return _integers(fields)


def _nothing(fields: list[bytes]) -> None:
    if any(field not in (b"", b"0") for field in fields):
        raise RemoteProtocolError("the command takes nothing more")


def _plain(command: Callable[[], Command]) -> Callable[[list[bytes]], Command]:
    def read(fields: list[bytes]) -> Command:
        _nothing(fields)
        return command()

    return read


def _at_speed(command: type[Close | Set]) -> Callable[[list[bytes]], Command]:
    def read(fields: list[bytes]) -> Command:
        _nothing(fields[1:])
        return command(*_integers([field for field in fields[:1] if field]))

    return read


_READERS: dict[str, Callable[[list[bytes]], Command]] = {
    Step.name: _step,
    Read.name: _plain(Read),
    Close.name: _at_speed(Close),
    Reset.name: _plain(Reset),
    Set.name: _at_speed(Set),
    Run.name: _plain(Run),
    QDump.name: _plain(QDump),
    QWrite.name: _qwrite,
    Arm.name: _arm,
    Delay.name: _delay,
}
