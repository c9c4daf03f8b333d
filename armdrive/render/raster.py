"""A fast canvas of dots with inks, for pictures that are redrawn many times a second.

Cells are stored as bytes, row by row, so that copying a backdrop or comparing two pictures is one
operation. The drawing loops dominate the desk's processor load, and are therefore written inline.
"""

from __future__ import annotations

import codecs
import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from armdrive.render.camera import Projection
from armdrive.render.canvas import BRAILLE_BITS, clip, slope_stroke
from armdrive.render.inks import PATTERNS, Ink, Layer, Pattern

# --- A finished picture, and how it differs from another -----------------------------------------

_BRAILLE = " " + "".join(chr(0x2800 + bits) for bits in range(1, 256))
_PLAIN = " " + "".join(chr(code) for code in range(1, 128))
"""The character of each cell value."""

_RUNS = re.compile(rb"\0*([^\0])(?:\1|\0)*|\0+")
"""Cells of one ink, including the empty cells around them, whose ink is invisible."""

_WORDS = re.compile(rb"[^\0]+")

_CHANGES = re.compile(rb"[^\0]+(?:\0{1,16}[^\0]+)*")
"""Changed cells, joined across short gaps, where a new span would cost more than the gap."""

_INKS = tuple(Ink)

Span = tuple[int, int, int]
"""Column, row and width, in cells."""


@dataclass(frozen=True, slots=True)
class Painted:
    """A picture row by row: `cells` hold dots or a character, with an ink, and letters on top."""

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
        """Return this picture stacked on top of another of the same width and kind."""
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
        """Yield the spans in which this picture differs from `before`.

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
    """Return a number whose bytes are nonzero where the two differ."""
    if one == other:
        return 0
    return int.from_bytes(one, "big") ^ int.from_bytes(other, "big")


Dots = tuple[float, float]
Ends = tuple[float, float, float, float]

_BITS = tuple(bits for row in BRAILLE_BITS for bits in row)
_FIRST_LETTER, _LAST_LETTER = 32, 126
_HALF = 0x8000
"""Half a dot in the braille loop's fixed-point numbers, which have 16 fractional bits."""


class Raster(ABC):
    """Dots with the origin at the top left, x to the right and y down."""

    braille: ClassVar[bool]
    dots_across: ClassVar[int]
    dots_down: ClassVar[int]
    dot_aspect: ClassVar[float]
    """A dot's height divided by its width, for cells twice as tall as wide."""

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = max(width, 0), max(height, 0)
        self.right = self.width * self.dots_across - 1
        self.bottom = self.height * self.dots_down - 1
        size = self.width * self.height
        self._cells = bytearray(size)
        self._inks = bytearray(size)
        self._letters = bytearray(size)

    def clear(self) -> None:
        """Erase everything."""
        for cells in (self._cells, self._inks, self._letters):
            cells[:] = bytes(len(cells))

    def taken_from(self, other: Raster) -> None:
        """Become a copy of another raster of this size."""
        self._cells[:] = other._cells
        self._inks[:] = other._inks
        self._letters[:] = other._letters

    def painted(self) -> Painted:
        """Return the picture as it is now."""
        cells, inks, letters = bytes(self._cells), bytes(self._inks), bytes(self._letters)
        return Painted(self.width, self.height, self.braille, cells, inks, letters)

    def draw(self, layer: Layer, seen: Projection) -> None:
        """Draw a layer through a projection: its lines, then its joints, then its letters."""
        dots = seen.dots
        for stroke in layer.strokes:
            self.line([dots(point) for point in stroke.points], stroke.ink)
        for joint in layer.joints:
            self.knob(dots(joint))
        for letters in layer.letters:
            x, y = dots(letters.at)
            column, row = round(x) // self.dots_across, round(y) // self.dots_down
            self.text(column, row, letters.text, letters.ink)

    def line(self, points: Sequence[Dots], ink: Ink) -> None:
        """Draw a line through points in dots, in its ink's pattern, clipped at the edges."""
        pattern = PATTERNS[ink]
        right, bottom = self.right, self.bottom
        count = 0
        for (x0, y0), (x1, y1) in pairwise(points):
            ends: Ends | None = (x0, y0, x1, y1)
            if not (
                0 <= x0 <= right and 0 <= x1 <= right and 0 <= y0 <= bottom and 0 <= y1 <= bottom
            ):
                ends = clip((x0, y0, x1, y1), right, bottom)
            if ends is not None:
                count = self._piece(ends, ink, pattern, count)

    @abstractmethod
    def _piece(self, ends: Ends, ink: Ink, pattern: Pattern, count: int) -> int:
        """Draw a straight piece between dots of the canvas; return `count` after it.

        `count` is the position in the line's pattern.
        """

    @abstractmethod
    def knob(self, dots: Dots) -> None:
        """Mark a joint."""

    def text(self, column: int, row: int, text: str, ink: Ink) -> None:
        """Write over the drawing, clipped at the edges.

        Names come from files: a character that is not printable ASCII becomes a question mark.
        """
        if not 0 <= row < self.height:
            return
        for place, letter in enumerate(text, column):
            if 0 <= place < self.width:
                plain = _FIRST_LETTER <= ord(letter) <= _LAST_LETTER
                self._letters[row * self.width + place] = ord(letter if plain else "?")
                self._inks[row * self.width + place] = ink

    def sample(self, column: int, row: int, width: int, ink: Ink) -> None:
        """Draw a horizontal line `width` cells long, as a sample of an ink."""
        y = row * self.dots_down + self.dots_down // 2
        first, last = column * self.dots_across, (column + width) * self.dots_across - 1
        self.line([(first, y), (last, y)], ink)


class BrailleRaster(Raster):
    """Two by four dots in a cell."""

    braille = True
    dots_across, dots_down, dot_aspect = 2, 4, 1.0

    def _piece(self, ends: Ends, ink: Ink, pattern: Pattern, count: int) -> int:
        x0, y0, x1, y1 = ends
        ran = self._thin(ends, ink, pattern, count)
        if pattern.thick:  # draw again, one dot to the right or down
            steep = abs(y1 - y0) > abs(x1 - x0)
            by_x, by_y = int(steep), int(not steep)
            shifted = clip((x0 + by_x, y0 + by_y, x1 + by_x, y1 + by_y), self.right, self.bottom)
            if shifted is not None:
                self._thin(shifted, ink, pattern, count)
        return ran

    def _thin(self, ends: Ends, ink: Ink, pattern: Pattern, count: int) -> int:
        x0, y0 = int(ends[0] + 0.5), int(ends[1] + 0.5)
        dx, dy = int(ends[2] + 0.5) - x0, int(ends[3] + 0.5) - y0
        steps = max(abs(dx), abs(dy))
        x, y = (x0 << 16) + _HALF, (y0 << 16) + _HALF
        by_x, by_y = (int(dx * 65536 / steps), int(dy * 65536 / steps)) if steps else (0, 0)
        cells, inks, width, bits = self._cells, self._inks, self.width, _BITS
        on, period = pattern.on, pattern.period
        for at in range(count, count + steps + 1):
            if period == 1 or at % period < on:
                row, column = y >> 16, x >> 16
                cell = (row >> 2) * width + (column >> 1)
                cells[cell] |= bits[(row & 3) << 1 | column & 1]
                if inks[cell] < ink:
                    inks[cell] = ink
            x += by_x
            y += by_y
        return count + steps

    def knob(self, dots: Dots) -> None:
        """Mark a joint with a square of nine dots."""
        x, y = round(dots[0]), round(dots[1])
        for row in range(max(y - 1, 0), min(y + 1, self.bottom) + 1):
            for column in range(max(x - 1, 0), min(x + 1, self.right) + 1):
                cell = (row >> 2) * self.width + (column >> 1)
                self._cells[cell] |= _BITS[(row & 3) << 1 | column & 1]
                self._inks[cell] = max(self._inks[cell], Ink.JOINT)


class PlainRaster(Raster):
    """One character per cell: inks differ by their marks, as patterns would be too coarse."""

    braille = False
    dots_across, dots_down, dot_aspect = 1, 1, 2.0

    def _piece(self, ends: Ends, ink: Ink, pattern: Pattern, count: int) -> int:
        x0, y0 = int(ends[0] + 0.5), int(ends[1] + 0.5)
        dx, dy = int(ends[2] + 0.5) - x0, int(ends[3] + 0.5) - y0
        steps = max(abs(dx), abs(dy))
        mark = ord(pattern.mark or slope_stroke(dx, dy))
        every = 1 if pattern.period == 1 else 2
        for step in range(steps + 1):
            if (count + step) % every == 0:
                share = step / steps if steps else 0.0
                cell = int(y0 + dy * share + 0.5) * self.width + int(x0 + dx * share + 0.5)
                if self._inks[cell] <= ink:
                    self._inks[cell] = ink
                    self._cells[cell] = mark
        return count + steps

    def knob(self, dots: Dots) -> None:
        """Mark a joint with its character."""
        self.line([dots, dots], Ink.JOINT)


def raster(width: int, height: int, *, braille: bool) -> Raster:
    """Return an empty raster of `width` by `height` cells."""
    return (BrailleRaster if braille else PlainRaster)(width, height)
