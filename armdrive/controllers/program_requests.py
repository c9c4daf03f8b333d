"""What the driver asks of a controller that keeps a program of its own, and what it hears."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ReadProgram:
    """Ask for the program that the device keeps by itself. Never moves anything."""


@dataclass(frozen=True, slots=True)
class WriteRow:
    """Write one row of the device's own program, in the device's words. Moves nothing."""

    words: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """The device's own program, row by row in its own words, as the device told it."""

    rows: tuple[tuple[int, ...], ...]

    def __str__(self) -> str:
        return f"a program of {len(self.rows)} rows"
