"""A grid of characters to draw lines on, with eight braille dots per cell or in plain ASCII."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

_BRAILLE_BASE = 0x2800
BRAILLE_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bit of a dot by its row and column in the cell (Unicode block U+2800, dots 1 to 8)."""

_STROKES = "-|/\\+"
_FAINT = "._"  # dotted lines and the table: any other mark replaces these

Segment = tuple[float, float, float, float]


class Canvas:
    """Dots with the origin at the top left, x to the right and y down.

    A braille cell holds 2 by 4 dots, an ASCII cell a single one. Lines are clipped at the edges,
    so coordinates may be any finite numbers.
    """

    def __init__(self, width_cells: int, height_cells: int, *, braille: bool) -> None:
        self.width_cells = max(0, width_cells)
        self.height_cells = max(0, height_cells)
        self.braille = braille
        self._bits = [[0] * self.width_cells for _ in range(self.height_cells)]
        self._over = [[""] * self.width_cells for _ in range(self.height_cells)]

    @property
    def width_dots(self) -> int:
        """Dots from left to right."""
        return self.width_cells * 2 if self.braille else self.width_cells

    @property
    def height_dots(self) -> int:
        """Dots from top to bottom."""
        return self.height_cells * 4 if self.braille else self.height_cells

    @property
    def dot_aspect(self) -> float:
        """A dot's height divided by its width, for cells twice as tall as wide."""
        return 1.0 if self.braille else 2.0

    def line(
        self, x0: float, y0: float, x1: float, y1: float, *, every: int = 1, stroke: str = ""
    ) -> None:
        """Draw a line between two points in dots; `every=3` draws every third dot.

        In ASCII, `stroke` is the character; by default it depends on the slope.
        """
        kept = clip((x0, y0, x1, y1), self.width_dots - 1, self.height_dots - 1)
        if kept is None:
            return
        mark = stroke or slope_stroke(x1 - x0, y1 - y0)
        ends = (round(kept[0]), round(kept[1]), round(kept[2]), round(kept[3]))
        for count, (x, y) in enumerate(_bresenham(*ends)):
            if count % every == 0:
                self._set(x, y, mark)

    def dot(self, x: float, y: float, mark: str = "o") -> None:
        """Set one dot if it lies on the canvas; in ASCII draw the character `mark`."""
        column, row = round(x), round(y)
        if 0 <= column < self.width_dots and 0 <= row < self.height_dots:
            self._set(column, row, mark)

    def text(self, cell_x: int, cell_y: int, text: str) -> None:
        """Write text over the drawing, clipped at the edges."""
        if not 0 <= cell_y < self.height_cells:
            return
        for offset, character in enumerate(text):
            if 0 <= cell_x + offset < self.width_cells:
                self._over[cell_y][cell_x + offset] = character

    def rows(self) -> list[str]:
        """Return the picture as one string per row, all of the full width."""
        return [
            "".join(over or self._cell(bits) for bits, over in zip(row, overs, strict=True))
            for row, overs in zip(self._bits, self._over, strict=True)
        ]

    def _cell(self, bits: int) -> str:
        if not bits:
            return " "
        return chr(_BRAILLE_BASE + bits) if self.braille else chr(bits)

    def _set(self, x: int, y: int, mark: str) -> None:
        if self.braille:
            self._bits[y // 4][x // 2] |= BRAILLE_BITS[y % 4][x % 2]
        else:
            row = self._bits[y]
            row[x] = ord(_crossed(chr(row[x]) if row[x] else "", mark))


def _crossed(there: str, mark: str) -> str:
    """Return the mark for two overlapping ASCII marks: solid over faint, special over stroke."""
    if not there or there == mark or there in _FAINT:
        return mark
    if mark in _FAINT:
        return there
    if mark in _STROKES:
        return "+" if there in _STROKES else there
    return mark


def slope_stroke(dx: float, dy: float) -> str:
    """Choose the ASCII character that looks most like a line of this slope."""
    if abs(dx) >= 2 * abs(dy):
        return "-"
    if abs(dy) >= 2 * abs(dx):
        return "|"
    return "\\" if (dx > 0) == (dy > 0) else "/"


def clip(segment: Segment, right: float, bottom: float) -> Segment | None:
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


def _bresenham(x0: int, y0: int, x1: int, y1: int) -> Iterator[tuple[int, int]]:
    """Yield the dots of a line, in integer arithmetic (Bresenham 1965)."""
    dx, dy = abs(x1 - x0), -abs(y1 - y0)
    step_x, step_y = (1 if x0 < x1 else -1), (1 if y0 < y1 else -1)
    error = dx + dy
    while True:
        yield x0, y0
        if x0 == x1 and y0 == y1:
            return
        doubled = 2 * error
        if doubled >= dy:
            error += dy
            x0 += step_x
        if doubled <= dx:
            error += dx
            y0 += step_y


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


def _is_utf8(name: str) -> bool:
    codeset = name.rpartition(".")[2].partition("@")[0]
    return codeset.lower().replace("-", "").replace("_", "") == "utf8"
