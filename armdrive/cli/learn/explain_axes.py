"""`explain --axes`: frames and link table found from an arm's joint axes, in drawn steps."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from typing import Any

from armdrive.cli.presenter import Result
from armdrive.render.canvas import can_braille
from armdrive.render.frame_steps import StepDrawing
from kinematics.chains.assignment import Assignment
from kinematics.chains.tables import rows_of
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import Transform, position_of, rotation_of
from kinematics.textbook.thirteen_steps import (
    AssignmentStep,
    assignment_steps,
    axes_lines,
    result_lines,
)

MOST_COLUMNS, PICTURE_ROWS = 78, 20


def explain_axes(found: Assignment, heading: Sequence[str]) -> Result:
    """Return the thirteen steps of an assignment, with a picture after each frame and link."""
    steps = assignment_steps(found)
    heading = (*heading, f"convention: {found.chain.convention.value}")
    return Result(axes_view(found, steps), _lines(found, steps, heading))


def _lines(
    found: Assignment, steps: Sequence[AssignmentStep], heading: Sequence[str]
) -> Iterator[str]:
    drawing = StepDrawing(found)
    braille = can_braille(sys.stdout.encoding, os.environ)
    width = min(shutil.get_terminal_size().columns - 1, MOST_COLUMNS)
    yield from heading
    yield from ("", "== Given: every joint at zero, in mm")
    yield from axes_lines(found)
    for index, step in enumerate(steps):
        before = steps[index - 1].stage if index else ""
        if step.stage != before:
            yield from ("", f"== {step.stage}")
        yield from step.lines
        last = index + 1 == len(steps) or steps[index + 1].stage != step.stage
        if last and step.known.frames:
            yield from drawing.rows(step.known, width, PICTURE_ROWS, braille=braille)
    yield from ("", "== Link table")
    yield from result_lines(found)


def axes_view(found: Assignment, steps: Sequence[AssignmentStep]) -> dict[str, Any]:
    """Return an assignment as plain data, in mm and degrees."""
    chain = found.chain
    normal, sliding, approach = columns(rotation_of(found.zero.tool))
    return {
        "name": chain.name,
        "convention": chain.convention.value,
        "axes": [
            {
                "joint": name,
                "kind": axis.kind.value,
                "point_mm": list(axis.line.point),
                "direction": list(axis.line.direction),
            }
            for axis, name in zip(found.zero.axes, chain.joint_names, strict=True)
        ],
        "tip": {
            "point_mm": list(position_of(found.zero.tool)),
            "approach": list(approach),
            "sliding": list(sliding),
            "normal": list(normal),
        },
        "relations": [relation.value for relation in found.relations],
        "steps": [
            {
                "step": step.number,
                "stage": step.stage,
                "text": [line.strip() for line in step.lines],
            }
            for step in steps
        ],
        "frames": [_rows(frame) for frame in found.frames],
        "b_mm": [list(point) for point in found.points],
        "choices": [
            {"frame": each.frame, "step": each.step, "choice": each.sentence}
            for each in found.choices
        ],
        "links": list(rows_of(chain)),
        "base": _rows(chain.base),
        "tool": _rows(chain.tool),
    }


def _rows(frame: Transform) -> list[list[float]]:
    return [list(row) for row in frame]
