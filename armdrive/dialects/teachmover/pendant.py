"""The program in a TeachMover's own memory: its rows, its file and its meaning on an arm.

A row holds absolute registers, which count half-steps from wherever they were zeroed. Adding the
arm's `origin` to registers gives motor steps of the model. So with another origin, other rows lead
to the same places.

In its file, each row is one line that people can read, compare and edit. A comment after the row
says what it means; it is ignored when the file is read. A row that is certainly a move is written
as `move`. Any other keeps the device's own words, so that it can be written back unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.dialects.speed_table import SpeedTable
from armdrive.errors import BadRequest, PendantFileError, Refused
from armdrive.errors.arguments import made_of, several
from armdrive.status import joints_view
from firmware_protocol.errors import BadField, ProtocolError
from firmware_protocol.fields import wrapped16
from firmware_protocol.teachmover import SPEED_MAX, ProgramRow
from firmware_protocol.teachmover.messages import MOTORS, MOVE_KIND, ROW_WORDS
from kinematics.spaces import Joints, Motors
from kinematics.text import counted, mm_text

FORMAT_LINE = "armdrive pendant program 1"
HEADING = """\
# The program in the memory of {arm}, as it was read {when}.
# `move`: row, the arm's own speed (0 to 245), six absolute registers in half-steps.
# `raw`: row, and seven words as the arm sends them; what such a row does is unknown.
# `origin`: add these to the registers to get motor steps of the model.
"""
_NUMBER = re.compile(r"-?[0-9]{1,9}")
_ROWS = several(
    made_of(ProgramRow, "a row of a program", "arm.controller.read_program().rows[0]"),
    "the rows of a program",
    "arm.controller.read_program().rows",
)


def is_move(row: ProgramRow) -> bool:
    """Return whether a row is certainly a move; the meaning of other kinds is unknown."""
    return row.kind == MOVE_KIND and row.speed <= SPEED_MAX


@dataclass(frozen=True, slots=True, repr=False)
class PendantProgram:
    """A program's rows in order; `origin` is None if the registers' zero point is unknown."""

    LARGEST_BYTES: ClassVar[int] = 1_000_000
    """A larger file is no program."""
    rows: tuple[ProgramRow, ...] = ()
    origin: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", _ROWS("rows", self.rows))

    @classmethod
    def from_words(
        cls, rows: Sequence[Sequence[int]], origin: tuple[int, ...] | None = None
    ) -> PendantProgram:
        """Decode the rows of a `DeviceProgram` from eight words each."""
        return cls(tuple(ProgramRow.from_words(row) for row in rows), origin)

    @classmethod
    def parse(cls, text: str) -> PendantProgram:
        """Parse a file. Raises `PendantFileError`, which names the line."""
        lines = [
            (number, words)
            for number, line in enumerate(text.splitlines(), 1)
            if (words := line.partition("#")[0].split())
        ]
        if not lines or lines[0][1] != FORMAT_LINE.split():
            raise PendantFileError(
                f"this is not a pendant program: the first line must be `{FORMAT_LINE}`"
            )
        origin: tuple[int, ...] | None = None
        rows: list[ProgramRow] = []
        for number, words in lines[1:]:
            if words[0] == "origin" and origin is None and not rows:
                origin = _numbers(words, MOTORS, number)
            else:
                rows.append(_row(words, number))
        return cls(tuple(rows), origin)

    def __repr__(self) -> str:  # short, for recordings of calls, which contain the rows as bytes
        return f"<PendantProgram of {counted(len(self.rows), 'row')}, origin {self.origin}>"

    @property
    def words(self) -> tuple[tuple[int, ...], ...]:
        """The eight words of every row."""
        return tuple(row.words for row in self.rows)

    def require_fitting(self, most: int) -> None:
        """Raise `BadRequest` if there are more rows than `most`, or two with the same number."""
        count = len(self.rows)
        if count > most:
            raise BadRequest(f"{count} rows are more than the arm's memory can hold: {most}")
        seen: dict[int, ProgramRow] = {}
        for row in self.rows:
            if seen.setdefault(row.number, row) != row:
                raise BadRequest(
                    f"row {row.number} is there twice: the arm keeps only one row of each number"
                )

    def require_origin(self, origin: tuple[int, ...] | None) -> None:
        """Raise `Refused` if the rows certainly lead to other places with this origin."""
        if origin is not None and any(by := self.shift_to(origin)):
            raise Refused(
                "the arm's registers count from elsewhere than when this program was read, so its "
                f"rows would now lead to places that differ by {by} half-steps. To shift the "
                "program, call `moved_to()`; to keep its numbers, call `without_origin()`"
            )

    def shift_to(self, origin: tuple[int, ...]) -> tuple[int, ...]:
        """Return what to add to registers to reach the same places with another origin.

        Without an origin of its own, the rows are mere numbers that nothing has to be added to.
        """
        old = self.origin or origin
        return tuple(wrapped16(was - now) for was, now in zip(old, origin, strict=True))

    def moved_to(self, origin: tuple[int, ...] | None) -> PendantProgram:
        """Return the rows that lead to the same places with another origin.

        Raises `Refused` if either origin is unknown, if a row is not a move (so the meaning of its
        numbers is unknown), or if a register would exceed its 16 bits.
        """
        if self.origin is None:
            raise Refused(
                "the program's origin is unknown: home the arm it was read from, and read it again"
            )
        if origin is None:
            raise Refused("the arm's registers count from an unknown position: home it first")
        by = self.shift_to(origin)
        if not any(by):
            return self
        return PendantProgram(tuple(_shifted(row, by) for row in self.rows), origin)

    def without_origin(self) -> PendantProgram:
        """Return the same rows as mere numbers, without their origin."""
        return replace(self, origin=None)

    def text(self, config: ArmConfig, when: str) -> str:
        """Return the program as the text of a file, with the meaning of each row on an arm."""
        transmission = config.model.transmission
        names = [motor.name for motor in transmission.motors] if transmission else []
        origin = [] if self.origin is None else [f"origin {' '.join(map(str, self.origin))}"]
        heading = HEADING.format(arm=config.name, when=when).rstrip("\n")
        columns = "#     row speed" + "".join(f"{name:>12.11}" for name in names)
        rows = [f"{_line(row)}   # {self.meaning(config, row)}" for row in self.rows]
        return "\n".join([FORMAT_LINE, heading, *origin, "", columns, *rows, ""])

    def view(self, config: ArmConfig) -> dict[str, Any]:
        """Return the program as plain data, with the target of each row on an arm."""
        rows = []
        for row in self.rows:
            place = self.place_of(config, row)
            joints, opening_mm = (None, None) if place is None else place
            rows.append(
                {
                    "row": row.number,
                    "words": list(row.words),
                    "joints": None if joints is None else joints_view(joints),
                    "gripper_mm": None if opening_mm is None else round(opening_mm, 3),
                }
            )
        return {"origin": self.origin, "rows": rows}

    def place_of(self, config: ArmConfig, row: ProgramRow) -> tuple[Joints, float] | None:
        """Return a row's posture and opening; None if it is no move or the origin is unknown."""
        transmission = config.model.transmission
        if not is_move(row) or self.origin is None or transmission is None:
            return None
        steps = (count + at for count, at in zip(row.positions, self.origin, strict=True))
        return transmission.to_joints(Motors(steps))

    def meaning(self, config: ArmConfig, row: ProgramRow) -> str:
        """Describe a row in words, as far as its meaning is known."""
        if not is_move(row):
            return "not a known move"
        fast = f"{SpeedTable(config.device.speed_table).rate_hz(row.speed):.0f} steps/s"
        place = self.place_of(config, row)
        return fast if place is None else f"{fast}; {place[0]}; fingers {mm_text(place[1])}"


def _shifted(row: ProgramRow, by: tuple[int, ...]) -> ProgramRow:
    if not is_move(row):
        raise Refused(f"row {row.number} is of an unknown kind, so it cannot be shifted")
    there = tuple(count + step for count, step in zip(row.positions, by, strict=True))
    try:
        return replace(row, positions=there)
    except BadField as error:
        raise Refused(f"row {row.number} cannot be shifted: {error}") from None


def _row(words: list[str], line: int) -> ProgramRow:
    numbers = _numbers(words, ROW_WORDS, line)
    try:
        if words[0] == "move":
            return ProgramRow.move(numbers[0], numbers[1], numbers[2:])
        if words[0] == "raw":
            return ProgramRow.from_words(numbers)
    except ProtocolError as error:
        raise PendantFileError(f"line {line}: {error}") from None
    raise PendantFileError(f"line {line}: a row begins with `move` or `raw`, not {words[0]!r}")


def _numbers(words: list[str], wanted: int, line: int) -> tuple[int, ...]:
    given = words[1:]
    wrong = next((word for word in given if not _NUMBER.fullmatch(word)), None)
    if wrong is not None:
        raise PendantFileError(f"line {line}: {wrong!r} is not a whole number of up to nine digits")
    if len(given) != wanted:
        raise PendantFileError(
            f"line {line}: `{words[0]}` needs {wanted} numbers, not {len(given)}"
        )
    return tuple(int(word) for word in given)


def _line(row: ProgramRow) -> str:
    """Return a row's words in columns that line up from row to row."""
    kind, numbers = "raw ", row.words
    if is_move(row):
        kind, numbers = "move", (row.number, row.speed, *row.positions)
    number, second, *others = numbers
    return f"{kind} {number:>4} {second:>5}" + "".join(f"{each:>12}" for each in others)
