"""A pendant's program as a text that a person can read, compare and edit: one row a line.

What a row means stands behind it as a comment, for reading alone. A row that is surely a move is
written as one; any other keeps the device's own words, so that every row comes back word for word.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from armdrive.errors import PendantFileError
from armdrive.teaching.pendantrows import PendantProgram, is_move
from firmware_protocol.errors import ProtocolError
from firmware_protocol.teachmover import ProgramRow

FIRST_LINE = "armdrive pendant program 1"
LARGEST_BYTES = 1_000_000
"""A file of a program that is larger is none."""

HEADING = """\
# The program in the memory of {arm}, as it was read {when}.
# `move`: row, the arm's own speed (0 to 245), six absolute registers in half-steps.
# `raw`: row, and seven words as the arm tells them; what such a row does is not known.
# `origin`: what the registers have to be added to, to be motor steps of the model.
"""

_NUMBER = re.compile(r"-?[0-9]{1,9}")
_ROW_NUMBERS = 8
_MOTORS = 6


def pendant_text(
    program: PendantProgram,
    arm: str,
    when: str,
    motors: Sequence[str],
    meanings: Sequence[str],
) -> str:
    """Return the text of a program; `meanings` stand behind the rows, one each, '' for none."""
    head = ("#     row speed", *motors)
    lines = [_columns(head)]
    for row, meaning in zip(program.rows, meanings, strict=True):
        line = _columns(_fields(row))
        lines.append(f"{line}   # {meaning}" if meaning else line)
    origin = [] if program.origin is None else [f"origin {' '.join(map(str, program.origin))}"]
    heading = HEADING.format(arm=arm, when=when).rstrip("\n")
    return "\n".join([FIRST_LINE, heading, *origin, "", *lines, ""])


def parse_pendant(text: str) -> PendantProgram:
    """Read the text of a program. Raises `PendantFileError` that names the line."""
    lines = [
        (number, words)
        for number, line in enumerate(text.splitlines(), 1)
        if (words := line.partition("#")[0].split())
    ]
    if not lines or lines[0][1] != FIRST_LINE.split():
        raise PendantFileError(
            f"it is no program of a pendant: its first line would be `{FIRST_LINE}`"
        )
    origin: tuple[int, ...] | None = None
    rows: list[ProgramRow] = []
    for number, words in lines[1:]:
        if words[0] == "origin" and origin is None and not rows:
            origin = _numbers(words, _MOTORS, number)
        else:
            rows.append(_row(words, number))
    return PendantProgram(tuple(rows), origin)


def _row(words: list[str], line: int) -> ProgramRow:
    numbers = _numbers(words, _ROW_NUMBERS, line)
    try:
        if words[0] == "move":
            return ProgramRow.move(numbers[0], numbers[1], numbers[2:])
        if words[0] == "raw":
            return ProgramRow.from_words(numbers)
    except ProtocolError as error:
        raise PendantFileError(f"line {line}: {error}") from None
    raise PendantFileError(f"line {line}: a row begins with `move` or `raw`, not {words[0]!r}")


def _numbers(words: list[str], wanted: int, line: int) -> tuple[int, ...]:
    told = words[1:]
    wrong = next((word for word in told if not _NUMBER.fullmatch(word)), None)
    if wrong is not None:
        raise PendantFileError(f"line {line}: {wrong!r} is no whole number of up to nine digits")
    if len(told) != wanted:
        raise PendantFileError(
            f"line {line}: {wanted} numbers stand behind `{words[0]}`, not {len(told)}"
        )
    return tuple(int(word) for word in told)


def _fields(row: ProgramRow) -> tuple[str, ...]:
    if is_move(row):
        return ("move", *map(str, (row.number, row.speed, *row.positions)))
    return ("raw ", *map(str, row.words))


def _columns(fields: Sequence[str]) -> str:
    """Lay fields out so that rows stand below one another."""
    first, *rest = fields
    if first.startswith("#"):
        return first + "".join(f"{name:>12.11}" for name in rest)
    number, second, *positions = rest
    return f"{first}{number:>5} {second:>5}" + "".join(f"{each:>12}" for each in positions)
