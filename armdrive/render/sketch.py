"""Sketches: curves and points in mm to scale, in characters or as a PNG or SVG file."""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain as chained
from pathlib import Path

from armdrive.errors import BadRequest
from armdrive.render.canvas import Ink, Raster
from kinematics.chains.chain import Chain
from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.workspace import section
from kinematics.text import rounded

Point = tuple[float, float]
Span = tuple[float, float]

_SMALLEST_MM = 1.0

# The room of sketches side by side, however large or small the terminal is.
MOST_COLUMNS, MOST_ROWS, LEAST_ROWS = 110, 36, 8


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
        return _box([(0.0, 0.0), *chained.from_iterable(self.curves), *self.points])

    @property
    def reach_box_mm(self) -> tuple[Span, Span]:
        """The least and greatest coordinates of curves and points; zeros if there are none."""
        return _box([*chained.from_iterable(self.curves), *self.points] or [(0.0, 0.0)])

    @property
    def is_wide(self) -> bool:
        """Whether there is more to see than a line."""
        return all(end - start > _SMALLEST_MM for start, end in self.reach_box_mm)

    @property
    def caption(self) -> str:
        """The dimensions in words."""
        (left, right), (low, high) = (
            (rounded(start, 0), rounded(end, 0)) for start, end in self.reach_box_mm
        )
        return f"{self.across} across, {left} to {right} mm; {self.up} up, {low} to {high} mm"


def sketch_rows(sketch: Sketch, width: int, height: int, *, braille: bool) -> list[str]:
    """Return the sketch as rows of characters, centred, with the same scale on both axes."""
    canvas = Raster(width, height, braille=braille)
    (left, right), (low, high) = sketch.box_mm
    across = max(right - left, _SMALLEST_MM)
    tall = max(high - low, _SMALLEST_MM)
    scale = min(canvas.right / across, canvas.bottom * canvas.dot_aspect / tall)
    shift = (canvas.right - across * scale) / 2.0

    def place(point: Point) -> Point:
        x, y = point
        return shift + (x - left) * scale, canvas.bottom - (y - low) * scale / canvas.dot_aspect

    zero_x, zero_y = place((0.0, 0.0))
    canvas.line([(zero_x, 0.0), (zero_x, canvas.bottom)], Ink.REACH)
    canvas.line([(0.0, zero_y), (canvas.right, zero_y)], Ink.REACH)
    for point in sketch.points:
        canvas.line([place(point)] * 2, Ink.TABLE)
    for curve in sketch.curves:
        canvas.line([place(point) for point in curve], Ink.BASE)
    return canvas.painted().rows()


def _box(points: Iterable[Point]) -> tuple[Span, Span]:
    across, up = ((min(axis), max(axis)) for axis in zip(*points, strict=True))
    return across, up


# --- Sketches of the reach: a section of a five-axis arm, or samples of any chain ----------------

_LATTICE = 24
_FINEST_MM = 5.0

_MAPPED = 300_000  # sampled postures of a map: more fill hardly another of its cells
_CELLS = 120  # cells along the larger side of a map; each shows at most one point


def section_sketch(arm: FiveAxisArm, pitch_deg: float, azimuth_deg: float) -> Sketch:
    """Return the boundary of the reach and a lattice of points in it, at a pitch and an azimuth."""
    cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg))
    low, high, _, _ = cut.box_mm
    spacing = max((high - low) / _LATTICE, _FINEST_MM)
    return Sketch(cut.boundary, cut.points(spacing), "distance from the base axis", "height z")


_VIEWS = ((0, 2), (0, 1), (1, 2))  # from the side, from above, from the front


def reach_sketches(chain: Chain) -> tuple[Sketch, ...]:
    """Return maps of the positions that a chain's tool reaches, from the side and from above.

    A planar arm, which shows as a line in other views, has the one view that its plane is seen in.
    """
    from kinematics.chains.many import reach_maps  # loads numpy, which the desk does without

    maps = reach_maps(chain, _VIEWS, _MAPPED, _CELLS)
    views = [
        Sketch((), tuple((float(a), float(b)) for a, b in places), "xyz"[across], "xyz"[up])
        for (across, up), places in zip(_VIEWS, maps, strict=True)
    ]
    return tuple([view for view in views if view.is_wide] or views)[:2]


# --- Files drawn by matplotlib, the optional extra `plot` ----------------------------------------

FORMATS = (".png", ".svg")

_WIDTH_IN, _HEIGHT_IN, _DOTS_PER_IN = 7.0, 6.0, 120


def check_output(path: Path) -> None:
    """Raise `BadRequest` for a file name that ends in neither .png nor .svg."""
    if path.suffix.lower() not in FORMATS:
        raise BadRequest(f"{path} should end in {' or '.join(FORMATS)}")


def terminal_lines(sketches: Sequence[Sketch], *, braille: bool) -> Iterator[str]:
    """Yield sketches side by side, as large as this terminal shows them, then their captions."""
    columns, rows = shutil.get_terminal_size()
    width = (min(columns, MOST_COLUMNS + 1) - len(sketches)) // len(sketches)
    height = max(min(rows - 4 - len(sketches), MOST_ROWS), LEAST_ROWS)
    pictures = [sketch_rows(each, width, height, braille=braille) for each in sketches]
    for row in zip(*pictures, strict=True):
        yield " ".join(row).rstrip()
    for sketch in sketches:
        yield sketch.caption


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
            "drawing PNG and SVG files needs matplotlib: pip install 'armdrive[plot]', "
            "or leave out the file to draw in the terminal"
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
