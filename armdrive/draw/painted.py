"""A finished picture of characters and inks, and which spans of it differ from another."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass

from armdrive.draw.inks import Ink

_BRAILLE = " " + "".join(chr(0x2800 + bits) for bits in range(1, 256))
_PLAIN = " " + "".join(chr(code) for code in range(1, 128))
"""From what a cell holds to its character."""

_RUNS = re.compile(rb"\0*([^\0])(?:\1|\0)*|\0+")
"""Cells of one ink with the empty ones about them: of those nobody sees which ink they have."""

_WORDS = re.compile(rb"[^\0]+")

_CHANGES = re.compile(rb"[^\0]+(?:\0{1,16}[^\0]+)*")
"""Changed cells. Past fewer unchanged ones, another span costs more than they do."""

_INKS = tuple(Ink)

Span = tuple[int, int, int]
"""Column, row and width, in cells."""


@dataclass(frozen=True, slots=True)
class Painted:
    """Cells row by row: dots or a character in `cells`, letters over them, and an ink each."""

    width: int
    height: int
    braille: bool
    cells: bytes
    inks: bytes
    letters: bytes

    def row(self, y: int) -> str:
        """Return the text of a row, of the full width."""
        start, end = y * self.width, (y + 1) * self.width
        table = _BRAILLE if self.braille else _PLAIN
        text: str = codecs.charmap_decode(self.cells[start:end], "strict", table)[0]
        over = self.letters[start:end]
        for word in _WORDS.finditer(over):
            text = text[: word.start()] + word.group().decode("ascii") + text[word.end() :]
        return text

    def above(self, other: Painted) -> Painted:
        """Return a picture with another one of this width and kind under it."""
        return Painted(
            self.width,
            self.height + other.height,
            self.braille,
            self.cells + other.cells,
            self.inks + other.inks,
            self.letters + other.letters,
        )

    def rows(self) -> list[str]:
        """Return the text of all rows."""
        return [self.row(y) for y in range(self.height)]

    def runs(self, y: int) -> Iterator[tuple[str, Ink]]:
        """Yield the pieces of a row that share an ink, from left to right, empty cells included."""
        text, start = self.row(y), y * self.width
        for run in _RUNS.finditer(self.inks, start, start + self.width):
            yield text[run.start() - start : run.end() - start], _INKS[(run.group(1) or b"\0")[0]]

    def changes(self, before: Painted | None) -> Iterator[Span]:
        """Yield the spans of this picture that show something else than another did.

        A picture of another size differs everywhere.
        """
        if before is None or not self._like(before):
            yield from ((0, y, self.width) for y in range(self.height if self.width else 0))
            return
        differing = _differing(self.cells, before.cells)
        differing |= _differing(self.inks, before.inks)
        differing |= _differing(self.letters, before.letters)
        if not differing:
            return
        flags = differing.to_bytes(len(self.cells), "big")
        for y in range(self.height):
            row = flags[y * self.width : (y + 1) * self.width]
            if any(row):
                for span in _CHANGES.finditer(row):
                    yield span.start(), y, span.end() - span.start()

    def _like(self, other: Painted) -> bool:
        return (self.width, self.height, self.braille) == (
            other.width,
            other.height,
            other.braille,
        )


def _differing(one: bytes, other: bytes) -> int:
    """Return a number whose bytes are not 0 where the two differ."""
    if one == other:
        return 0
    return int.from_bytes(one, "big") ^ int.from_bytes(other, "big")
