"""The program in an arm's own memory as a value: rows of absolute registers, and what they mean.

Registers count half-steps from wherever they were zeroed; `origin` is what they have to be added
to, to be motor steps of the model, in the arm that the rows were read from. Rows that mean the same
places under another origin are other rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from armdrive.errors import BadRequest, DeviceFault, Refused
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.teachmover import SPEED_MAX, ProgramRow
from firmware_protocol.teachmover.program import MOVE_KIND

_SPAN = 1 << 16
"""Registers wrap after so many steps."""


def is_move(row: ProgramRow) -> bool:
    """Tell whether a row is surely a move; what other kinds mean is unknown."""
    return row.kind == MOVE_KIND and row.speed <= SPEED_MAX


@dataclass(frozen=True, slots=True, repr=False)
class PendantProgram:
    """Rows of a program in their order; `origin` is None where nobody knows what they mean."""

    rows: tuple[ProgramRow, ...] = ()
    origin: tuple[int, ...] | None = None

    @classmethod
    def from_words(
        cls, rows: Sequence[Sequence[int]], origin: tuple[int, ...] | None = None
    ) -> PendantProgram:
        """Read the rows from eight words each; raises `DeviceFault` for what is no row."""
        try:
            return cls(tuple(ProgramRow.from_words(row) for row in rows), origin)
        except RemoteProtocolError as error:
            raise DeviceFault(f"the program in the arm cannot be read: {error}") from None

    def __repr__(self) -> str:  # in a recording of calls, where the rows pass as bytes anyway
        return f"<PendantProgram of {len(self.rows)} rows, origin {self.origin}>"

    @property
    def words(self) -> tuple[tuple[int, ...], ...]:
        """Every row in its eight words."""
        return tuple(row.words for row in self.rows)

    def require_fitting(self, most: int) -> None:
        """Raise `BadRequest` for more rows than a memory has, or for a number twice."""
        count = len(self.rows)
        if count > most:
            raise BadRequest(f"{count} rows are more than the arm's memory can hold: {most}")
        self.require_once()

    def require_once(self) -> None:
        """Raise `BadRequest` for a number that two different rows have."""
        seen: dict[int, ProgramRow] = {}
        for row in self.rows:
            if seen.setdefault(row.number, row) != row:
                raise BadRequest(f"row {row.number} is there twice: the arm keeps one of a number")

    def require_origin(self, origin: tuple[int, ...] | None) -> None:
        """Raise `Refused` where the rows are known to mean other places under this origin."""
        if self.origin is None or origin is None or not _shift(self.origin, origin):
            return
        raise Refused(
            "the arm's registers count from elsewhere than when this program was read, so that its "
            f"rows would lead to other places now: by {self.shift_to(origin)} half-steps. To "
            "shift it, call `moved_to()`; if it is meant as it is, call `without_origin()`"
        )

    def shift_to(self, origin: tuple[int, ...]) -> tuple[int, ...]:
        """Return by how much registers differ that mean the same places under another origin."""
        return _shift(self.origin or origin, origin) or (0,) * len(origin)

    def moved_to(self, origin: tuple[int, ...] | None) -> PendantProgram:
        """Return the rows that mean the same places under another origin.

        Raises `Refused` where either origin is unknown, a row is no move (nobody knows what its
        numbers mean), or a register would leave its 16 bits.
        """
        if self.origin is None or origin is None:
            whose = "the program was read" if self.origin is None else "the arm"
            raise Refused(f"nobody knows what the registers counted from of {whose}: home it first")
        by = self.shift_to(origin)
        if not any(by):
            return self
        return PendantProgram(tuple(_shifted(row, by) for row in self.rows), origin)

    def without_origin(self) -> PendantProgram:
        """Return the same rows, meant as numbers alone."""
        return replace(self, origin=None)


def _shift(old: Sequence[int], new: Sequence[int]) -> tuple[int, ...]:
    """Return what to add to registers; empty where nothing has to be."""
    by = tuple((a - b + _SPAN // 2) % _SPAN - _SPAN // 2 for a, b in zip(old, new, strict=True))
    return by if any(by) else ()


def _shifted(row: ProgramRow, by: tuple[int, ...]) -> ProgramRow:
    if not is_move(row):
        raise Refused(f"row {row.number} is of an unknown kind: nobody knows how to shift it")
    there = tuple(count + step for count, step in zip(row.positions, by, strict=True))
    try:
        return replace(row, positions=there)
    except BadField as error:
        raise Refused(f"row {row.number} cannot be shifted: {error}") from None
