"""Sketches as PNG or SVG files, drawn by matplotlib: the optional extra `plot`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from armdrive.draw.sketch import Sketch
from armdrive.errors import BadRequest

FORMATS = (".png", ".svg")

_WIDTH_IN, _HEIGHT_IN, _DOTS_PER_IN = 7.0, 6.0, 120


def check_output(path: Path) -> None:
    """Raise `BadRequest` for a file that is neither PNG nor SVG by its name."""
    if path.suffix.lower() not in FORMATS:
        raise BadRequest(f"{path} should end in {' or '.join(FORMATS)}")


def save_sketches(sketches: Sequence[Sketch], title: str, path: Path) -> None:
    """Draw the sketches side by side into a file.

    Raises `BadRequest` where matplotlib is missing or the ending is unknown, OSError where the
    file cannot be written.
    """
    check_output(path)
    try:
        figure_module = import_module("matplotlib.figure")
    except ModuleNotFoundError:
        raise BadRequest(
            "drawing PNG and SVG files needs matplotlib: pip install 'armdrive[plot]' "
            "(without --output the picture is drawn in the terminal)"
        ) from None
    size = (_WIDTH_IN * len(sketches), _HEIGHT_IN)
    figure = figure_module.Figure(figsize=size, layout="constrained")
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
