"""Pictures in characters: inks and layers, a fast raster of dots, and the finished picture.

A raster is redrawn many times a second. Its cells are stored in arrays, row by row, so that copying
a backdrop or comparing a row is one operation. The drawing loops dominate the desk's processor
load: they go over all dots of a line at once.

Colour is never the only difference: each ink has its own pattern in braille and mark in ASCII.
"""

from __future__ import annotations

import os
import re
import sys
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from types import MappingProxyType

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


# Every ink that draws lines.
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

# Column, row and width, in cells.
Span = tuple[int, int, int]

CLOSE = 16  # changed cells at most this far apart share a span: a new one would cost as many bytes

_EMPTY_BRAILLE = "\u2800"

# Cells of one ink, including the empty cells around them, whose ink is invisible.
_RUNS = re.compile(rb"\0*([^\0])(?:\1|\0)*|\0+")

_INKS = tuple(Ink)


@dataclass(frozen=True, slots=True)
class Painted:
    """A picture: its characters row by row, and the ink of each."""

    width: int
    height: int
    text: str
    inks: bytes

    def row(self, y: int) -> str:
        """Return the text of a row, of the full width."""
        return self.text[y * self.width : (y + 1) * self.width]

    def rows(self) -> list[str]:
        """Return the text of all rows."""
        return [self.row(y) for y in range(self.height)]

    def inks_of(self, y: int) -> bytes:
        """Return the inks of a row."""
        return self.inks[y * self.width : (y + 1) * self.width]

    def runs(self, y: int) -> Iterator[tuple[str, Ink]]:
        """Yield the pieces of a row that share an ink, from left to right, empty cells included."""
        text = self.row(y)
        for run in _RUNS.finditer(self.inks_of(y)):
            yield text[run.start() : run.end()], _INKS[(run.group(1) or b"\0")[0]]

    def changes(self, before: Painted | None) -> Iterator[Span]:
        """Yield the spans in which this picture differs from `before`.

        A picture of another size differs everywhere.
        """
        if before is None or (self.width, self.height) != (before.width, before.height):
            yield from ((0, y, self.width) for y in range(self.height if self.width else 0))
            return
        for y in range(self.height):
            now, then = ((each.row(y), each.inks_of(y)) for each in (self, before))
            if now == then:
                continue
            cells = enumerate(zip(*now, *then, strict=True))
            changed = [x for x, (a, b, c, d) in cells if a != c or b != d]
            first = changed[0]
            for x, following in pairwise([*changed, self.width + CLOSE]):
                if following - x > CLOSE:
                    yield first, y, x + 1 - first
                    first = following


# --- Lines as dots, and dots as cells ------------------------------------------------------------

Dots = tuple[float, float]
Ends = tuple[float, float, float, float]

# The bit of a dot by its row and column in the cell (Unicode block U+2800, dots 1 to 8).
_BITS = (0x01, 0x08, 0x02, 0x10, 0x04, 0x20, 0x40, 0x80)

_FIRST_LETTER, _LAST_LETTER = 32, 126

_UTF_16 = f"utf-16-{sys.byteorder[0]}e"  # of an array of characters


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
    if 0 <= x0 <= right and 0 <= x1 <= right and 0 <= y0 <= bottom and 0 <= y1 <= bottom:
        return segment
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


def _trace(ends: Ends) -> list[tuple[int, int]]:
    """Return the dots of a straight piece from end to end, column and row of each."""
    x0, y0 = int(ends[0] + 0.5), int(ends[1] + 0.5)
    dx, dy = int(ends[2] + 0.5) - x0, int(ends[3] + 0.5) - y0
    steps = max(abs(dx), abs(dy))
    if not steps:
        return [(x0, y0)]
    half, whole = steps, 2 * steps  # whole numbers that round to the nearest dot
    return [
        (x0 + (2 * dx * at + half) // whole, y0 + (2 * dy * at + half) // whole)
        for at in range(steps + 1)
    ]


class Raster:
    """Dots with the origin at the top left, x to the right and y down.

    A braille cell has two by four dots. In ASCII a cell is one dot, and inks differ by their marks,
    as patterns would be too coarse.
    """

    def __init__(self, width: int, height: int, *, braille: bool) -> None:
        self.width, self.height = max(width, 0), max(height, 0)
        self.braille = braille
        self.dots_across, self.dots_down = (2, 4) if braille else (1, 1)
        self.dot_aspect = 1.0 if braille else 2.0
        """A dot's height divided by its width, for cells twice as tall as wide."""
        self.right = self.width * self.dots_across - 1
        self.bottom = self.height * self.dots_down - 1
        size = self.width * self.height
        self._cells = array("H", [ord(_EMPTY_BRAILLE if braille else " ")]) * size
        self._inks = bytearray(size)

    def copy(self) -> Raster:
        """Return another raster with the same picture."""
        other = Raster(self.width, self.height, braille=self.braille)
        other._cells[:], other._inks[:] = self._cells, self._inks
        return other

    def painted(self) -> Painted:
        """Return the picture as it is now."""
        text = self._cells.tobytes().decode(_UTF_16).replace(_EMPTY_BRAILLE, " ")
        return Painted(self.width, self.height, text, bytes(self._inks))

    def draw(self, layer: Layer, seen: Projection) -> None:
        """Draw the lines and joints of a layer through a projection."""
        for stroke in layer.strokes:
            self.line([seen.dots(point) for point in stroke.points], stroke.ink)
        for joint in layer.joints:
            self.knob(seen.dots(joint))

    def write(self, layer: Layer, seen: Projection) -> None:
        """Write the letters of a layer. Lines that are drawn later would spoil them."""
        for letters in layer.letters:
            x, y = seen.dots(letters.at)
            column, row = round(x) // self.dots_across, round(y) // self.dots_down
            self.text(column, row, letters.text, letters.ink)

    def line(self, points: Sequence[Dots], ink: Ink) -> None:
        """Draw a line through points in dots, in its ink's pattern, clipped at the edges."""
        pattern = PATTERNS[ink]
        on, period = pattern.on, pattern.period
        if not self.braille:
            on, period = 1, min(period, 2)
        drawn = 0  # dots so far: the pattern goes on around corners
        for (x0, y0), (x1, y1) in pairwise(points):
            ends = clip((x0, y0, x1, y1), self.right, self.bottom)
            if ends is None:
                continue
            dots = _trace(ends)
            shown = dots
            if period > 1:
                shown = [dot for at, dot in enumerate(dots, drawn) if at % period < on]
            drawn += len(dots) - 1
            dx, dy = dots[-1][0] - dots[0][0], dots[-1][1] - dots[0][1]
            self._mark(shown, ink, pattern.mark or slope_stroke(dx, dy))
            if pattern.thick and self.braille:  # draw again, one dot to the right or down
                steep = abs(dy) > abs(dx)
                self._mark([(x + steep, y + (not steep)) for x, y in shown], ink)

    def knob(self, dots: Dots) -> None:
        """Mark a joint: with a square of nine dots, or with its character."""
        x, y = round(dots[0]), round(dots[1])
        around = (-1, 0, 1) if self.braille else (0,)
        square = [(x + by_x, y + by_y) for by_y in around for by_x in around]
        self._mark(square, Ink.JOINT, PATTERNS[Ink.JOINT].mark)

    def _mark(self, dots: Iterable[tuple[int, int]], ink: Ink, mark: str = "") -> None:
        """Draw dots, those outside left out; a cell keeps the greatest of its inks."""
        cells, inks, width, right, bottom = (
            self._cells, self._inks, self.width, self.right, self.bottom
        )  # fmt: skip
        for x, y in dots:
            if not (0 <= x <= right and 0 <= y <= bottom):
                continue
            if self.braille:
                cell = (y >> 2) * width + (x >> 1)
                cells[cell] |= _BITS[(y & 3) << 1 | x & 1]
            else:
                cell = y * width + x
                if inks[cell] <= ink:
                    cells[cell] = ord(mark)
            if inks[cell] < ink:
                inks[cell] = ink

    def text(self, column: int, row: int, text: str, ink: Ink) -> None:
        """Write over the drawing, clipped at the edges.

        Names come from files: a character that is not printable ASCII becomes a question mark.
        """
        if not 0 <= row < self.height:
            return
        for place, letter in enumerate(text, column):
            if 0 <= place < self.width:
                plain = _FIRST_LETTER <= ord(letter) <= _LAST_LETTER
                self._cells[row * self.width + place] = ord(letter if plain else "?")
                self._inks[row * self.width + place] = ink

    def sample(self, column: int, row: int, width: int, ink: Ink) -> None:
        """Draw a horizontal line `width` cells long, as a sample of an ink."""
        y = row * self.dots_down + self.dots_down // 2
        first, last = column * self.dots_across, (column + width) * self.dots_across - 1
        self.line([(first, y), (last, y)], ink)


# --- Whether a terminal can show braille ---------------------------------------------------------

# The Linux console has no braille in its font; a dumb terminal has nothing.
_PLAIN_TERMINALS = ("linux", "dumb")

# In the order of precedence in POSIX: the first variable that is set decides.
_LOCALE_VARIABLES = ("LC_ALL", "LC_CTYPE", "LANG")


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
