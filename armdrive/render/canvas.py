"""Pictures in characters: inks and layers, a fast raster of dots, and the finished picture.

A raster is redrawn many times a second. Its cells are stored as bytes, row by row, so that copying
a backdrop or comparing two pictures is one operation. The drawing loops dominate the desk's
processor load, and are therefore written inline.

Colour is never the only difference: each ink has its own pattern in braille and mark in ASCII.
"""

from __future__ import annotations

import codecs
import os
import re
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from types import MappingProxyType
from typing import ClassVar

from armdrive.render.camera import Projection
from kinematics.geometry import Point


class Ink(IntEnum):
    """The meaning of a line. A cell with several inks takes the style of the greatest."""

    NONE = 0
    TABLE = 1
    REACH = 2
    GUARD = 3
    BASE = 4
    PLANNED = 5
    DRIVEN = 6
    GOAL = 7
    ARM = 8
    GRIPPER = 9
    JOINT = 10
    AXIS = 11
    WORD = 12


@dataclass(frozen=True, slots=True)
class Pattern:
    """The look of an ink: of each `period` dots of a line, the first `on` are drawn.

    `mark` is its character in ASCII; if empty, the character depends on the slope. `word` is its
    name in the legend.
    """

    on: int = 1
    period: int = 1
    mark: str = ""
    thick: bool = False
    word: str = ""


PATTERNS: Mapping[Ink, Pattern] = MappingProxyType(
    {
        Ink.TABLE: Pattern(1, 6, "."),
        Ink.REACH: Pattern(1, 3, ":", word="reach"),
        Ink.GUARD: Pattern(4, 6, "#", word="guard"),
        Ink.BASE: Pattern(),
        Ink.PLANNED: Pattern(2, 5, "+", word="way"),
        Ink.DRIVEN: Pattern(1, 1, "~", word="driven"),
        Ink.GOAL: Pattern(5, 8, "=", word="goal G"),
        Ink.ARM: Pattern(thick=True),
        Ink.GRIPPER: Pattern(),
        Ink.JOINT: Pattern(1, 1, "o"),
        Ink.AXIS: Pattern(),
    }
)
"""Every ink that draws lines."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points in mm; its pattern continues around the corners."""

    ink: Ink
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Letters:
    """Text at a point in mm."""

    ink: Ink
    at: Point
    text: str


@dataclass(frozen=True, slots=True)
class Layer:
    """Lines, texts, and points that are marked as joints."""

    strokes: tuple[Stroke, ...] = ()
    letters: tuple[Letters, ...] = ()
    joints: tuple[Point, ...] = ()

    def __add__(self, other: Layer) -> Layer:
        return Layer(
            self.strokes + other.strokes,
            self.letters + other.letters,
            self.joints + other.joints,
        )


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


_BRAILLE_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bit of a dot by its row and column in the cell (Unicode block U+2800, dots 1 to 8)."""

Dots = tuple[float, float]
Ends = tuple[float, float, float, float]

_BITS = tuple(bits for row in _BRAILLE_BITS for bits in row)
_FIRST_LETTER, _LAST_LETTER = 32, 126
_HALF = 0x8000
"""Half a dot in the braille loop's fixed-point numbers, which have 16 fractional bits."""


def slope_stroke(dx: float, dy: float) -> str:
    """Choose the ASCII character that looks most like a line of this slope."""
    if abs(dx) >= 2 * abs(dy):
        return "-"
    if abs(dy) >= 2 * abs(dx):
        return "|"
    return "\\" if (dx > 0) == (dy > 0) else "/"


def clip(segment: Ends, right: float, bottom: float) -> Ends | None:
    """Clip a segment to 0..right, 0..bottom (Liang and Barsky 1984); None if it is all outside.

    The bounds are dot centres, so every clipped point rounds to an existing dot.
    """
    x0, y0, x1, y1 = segment
    if right < 0 or bottom < 0:
        return None
    enter, leave = 0.0, 1.0
    dx, dy = x1 - x0, y1 - y0
    for towards, room in ((-dx, x0), (dx, right - x0), (-dy, y0), (dy, bottom - y0)):
        if towards == 0:
            if room < 0:
                return None
        elif towards < 0:
            enter = max(enter, room / towards)
        else:
            leave = min(leave, room / towards)
    if enter > leave:
        return None
    start = (_within(x0 + enter * dx, right), _within(y0 + enter * dy, bottom))
    return (*start, _within(x0 + leave * dx, right), _within(y0 + leave * dy, bottom))


def _within(value: float, top: float) -> float:
    """Undo rounding errors that put a value past an edge."""
    return min(max(value, 0.0), top)


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


# --- Whether a terminal can show braille ---------------------------------------------------------

_PLAIN_TERMINALS = ("linux", "dumb")
"""The Linux console has no braille in its font; a dumb terminal has nothing."""

_LOCALE_VARIABLES = ("LC_ALL", "LC_CTYPE", "LANG")
"""In the order of precedence in POSIX: the first variable that is set decides."""


def can_braille(encoding: str | None, environ: Mapping[str, str]) -> bool:
    """Return whether a terminal can show braille characters.

    The output encoding must be UTF-8, the locale must not contradict it, and the terminal's font
    must have the characters. `encoding` is the output stream's, for example
    `sys.stdout.encoding`.
    """
    if not _is_utf8(encoding or "") or environ.get("TERM", "") in _PLAIN_TERMINALS:
        return False
    locale = next((environ[name] for name in _LOCALE_VARIABLES if environ.get(name)), None)
    return locale is None or _is_utf8(locale)


def draws_braille(*, ascii_only: bool = False) -> bool:
    """Return whether to draw with braille and lines here; else all is drawn in plain letters."""
    return not ascii_only and can_braille(sys.stdout.encoding, os.environ)


def _is_utf8(name: str) -> bool:
    codeset = name.rpartition(".")[2].partition("@")[0]
    return codeset.lower().replace("-", "").replace("_", "") == "utf8"
