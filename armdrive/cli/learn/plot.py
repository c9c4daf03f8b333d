"""Draw what an arm can reach, in the terminal or into a file."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator

from armdrive.cli.learn.models import find_subject
from armdrive.cli.presenter import Result
from armdrive.errors import BadRequest
from armdrive.render.canvas import draws_braille
from armdrive.render.sketch import (
    Sketch,
    reach_sketches,
    save_sketches,
    section_sketch,
    terminal_lines,
)
from armdrive.storage.files import require_free
from kinematics.presets import PRESETS, preset

DEFAULT_PITCH_DEG = -90.0


def plot(options: argparse.Namespace) -> Result:
    """Draw in the terminal, or into the file that --output names."""
    if options.output is not None:
        require_free(options.output, overwrite=options.force)
    title, sketches = _sketches(options)
    lines: Iterable[str] = _drawn(title, sketches, plain=options.ascii)
    if options.output is not None:
        save_sketches(sketches, title, options.output)
        lines = (f"{title}: written to {options.output}",)
    view = {
        "model": options.model,
        "title": title,
        "output": str(options.output) if options.output else None,
        "views": [_view(sketch) for sketch in sketches],
    }
    return Result(view, lines)


def _sketches(options: argparse.Namespace) -> tuple[str, tuple[Sketch, ...]]:
    if options.model in PRESETS:
        model = preset(options.model)
        pitch = DEFAULT_PITCH_DEG if options.pitch is None else options.pitch
        azimuth = options.azimuth or 0.0
        title = f"{model.title}: reach of the finger tips at pitch {pitch:g}°, azimuth {azimuth:g}°"
        return title, (section_sketch(model.arm, pitch, azimuth),)
    found = find_subject(options.model)
    if options.pitch is not None or options.azimuth is not None:
        raise BadRequest(
            "--pitch and --azimuth are for arms of the Mini-mover's build "
            f"({', '.join(PRESETS)}); other arms are drawn whole"
        )
    return f"{found.title}: positions that the tool reached", reach_sketches(found.chain)


def _drawn(title: str, sketches: tuple[Sketch, ...], *, plain: bool) -> Iterator[str]:
    braille = draws_braille(ascii_only=plain)
    yield title if braille else title.replace("°", " deg")
    yield from terminal_lines(sketches, braille=braille)


def _view(sketch: Sketch) -> dict[str, object]:
    return {
        "across": sketch.across,
        "up": sketch.up,
        "box_mm": sketch.reach_box_mm,
        "curves": sketch.curves,
        "points": sketch.points,
    }
