"""Draw curves and points in mm to scale, in characters or as a PNG or SVG file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from pathlib import Path

from armdrive.errors import BadRequest
from armdrive.render.canvas import Canvas

Point = tuple[float, float]
Span = tuple[float, float]

_SPARSE = 4
_SMALLEST_MM = 1.0
_POINT = "."


@dataclass(frozen=True, slots=True)
class Sketch:
    """A drawing of closed or open curves and of points.

    `across` and `up` name the two axes. The axes themselves, usually the table and the base axis,
    are drawn dotted.
    """

    curves: tuple[tuple[Point, ...], ...]
    points: tuple[Point, ...]
    across: str
    up: str

    @property
    def box_mm(self) -> tuple[Span, Span]:
        """The least and greatest coordinates, including the origin."""
        return _box([(0.0, 0.0), *chain.from_iterable(self.curves), *self.points])

    @property
    def reach_box_mm(self) -> tuple[Span, Span]:
        """The least and greatest coordinates of curves and points; zeros if there are none."""
        return _box([*chain.from_iterable(self.curves), *self.points] or [(0.0, 0.0)])

    @property
    def caption(self) -> str:
        """The dimensions in words."""
        (left, right), (low, high) = self.reach_box_mm
        return (
            f"{self.across} across, {left:.0f} to {right:.0f} mm; "
            f"{self.up} up, {low:.0f} to {high:.0f} mm"
        )


def sketch_rows(sketch: Sketch, width: int, height: int, *, braille: bool) -> list[str]:
    """Return the sketch as rows of characters, centred, with the same scale on both axes."""
    canvas = Canvas(width, height, braille=braille)
    (left, right), (low, high) = sketch.box_mm
    across = max(right - left, _SMALLEST_MM)
    tall = max(high - low, _SMALLEST_MM)
    columns, rows = canvas.width_dots - 1, canvas.height_dots - 1
    scale = min(columns / across, rows * canvas.dot_aspect / tall)
    shift = (columns - across * scale) / 2.0

    def place(point: Point) -> Point:
        x, y = point
        return shift + (x - left) * scale, rows - (y - low) * scale / canvas.dot_aspect

    zero_x, zero_y = place((0.0, 0.0))
    canvas.line(zero_x, 0, zero_x, rows, every=_SPARSE, stroke=":")
    canvas.line(0, zero_y, columns, zero_y, every=_SPARSE, stroke="_")
    for point in sketch.points:
        canvas.dot(*place(point), _POINT)
    for curve in sketch.curves:
        for start, end in pairwise(curve):
            canvas.line(*place(start), *place(end))
    return canvas.rows()


def _box(points: Iterable[Point]) -> tuple[Span, Span]:
    across, up = ((min(axis), max(axis)) for axis in zip(*points, strict=True))
    return across, up


# --- Files drawn by matplotlib, the optional extra `plot` ----------------------------------------

FORMATS = (".png", ".svg")

_WIDTH_IN, _HEIGHT_IN, _DOTS_PER_IN = 7.0, 6.0, 120


def check_output(path: Path) -> None:
    """Raise `BadRequest` for a file name that ends in neither .png nor .svg."""
    if path.suffix.lower() not in FORMATS:
        raise BadRequest(f"{path} should end in {' or '.join(FORMATS)}")


def save_sketches(sketches: Sequence[Sketch], title: str, path: Path) -> None:
    """Draw sketches next to each other in a file.

    Raises `BadRequest` if matplotlib is missing or the ending is unknown, and `OSError` if the file
    cannot be written.
    """
    check_output(path)
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        raise BadRequest(
            "drawing PNG and SVG files needs matplotlib: pip install 'armdrive[plot]' "
            "(without --output the picture is drawn in the terminal)"
        ) from None
    size = (_WIDTH_IN * len(sketches), _HEIGHT_IN)
    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(title)
    for number, sketch in enumerate(sketches, 1):
        axes = figure.add_subplot(1, len(sketches), number)
        axes.axhline(0.0, color="0.6", linewidth=0.8)
        axes.axvline(0.0, color="0.6", linewidth=0.8)
        if sketch.points:
            axes.plot(*zip(*sketch.points, strict=True), ".", markersize=1.5, color="0.55")
        for curve in sketch.curves:
            axes.plot(*zip(*curve, strict=True), color="tab:blue", linewidth=1.2)
        axes.set_aspect("equal")
        axes.set_xlabel(f"{sketch.across} / mm")
        axes.set_ylabel(f"{sketch.up} / mm")
    figure.savefig(path, dpi=_DOTS_PER_IN)
