"""The file of an arm's saved points: list, show, rename and delete them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from armdrive.cli.arm_files import chosen_points
from armdrive.cli.presenter import Result
from armdrive.status import pose_view
from armdrive.storage.points import StepList, Taught, point_view
from kinematics.text import counted


def list_points(options: argparse.Namespace) -> Result:
    """List the points and sequences, and where their file is."""
    _, book = chosen_points(options)
    taught = book.read()
    return Result(
        {
            "file": str(book.path),
            "points": {name: point_view(each) for name, each in taught.points.items()},
            "sequences": {name: _steps_view(each) for name, each in taught.sequences.items()},
        },
        _listed(book.path, taught),
    )


def _listed(path: Path, taught: Taught) -> Iterator[str]:
    yield str(path)
    width = max(map(len, [*taught.points, *taught.sequences]), default=0) + 2
    for name, point in taught.points.items():
        yield f"  {name:<{width}}{point.joints}{f'   {point.note}' * bool(point.note)}"
    for name, steps in taught.sequences.items():
        note = f"   {steps.note}" * bool(steps.note)
        yield f"  {name:<{width}}sequence of {counted(len(steps.steps), 'step')}{note}"
    if not (taught.points or taught.sequences):
        yield "  no points yet: `armdrive points save NAME` saves the place where the arm is"


def show(options: argparse.Namespace) -> Result:
    """Show a point, or the steps of a sequence."""
    config, book = chosen_points(options)
    steps = book.read().sequences.get(options.name)
    if steps is not None:
        numbered = [f"{number:>3}  {step}" for number, step in enumerate(steps.steps, 1)]
        return Result({"name": options.name, **_steps_view(steps)}, numbered)
    point = book[options.name]
    pose = config.model.arm.fk(point.joints)
    lines = [f"joints {point.joints}", f"tip {pose}"]
    if point.opening_mm is not None:
        lines.append(f"gripper {point.opening_mm:.1f} mm")
    if point.taught is not None:
        lines.append(f"taught {point.taught:%Y-%m-%d %H:%M}")
    if point.note:
        lines += point.note.split("\n")
    return Result({"name": options.name, **point_view(point), "pose": pose_view(pose)}, lines)


def rename(options: argparse.Namespace) -> Result:
    """Rename a point, also in sequences."""
    _, book = chosen_points(options)
    book.rename(options.name, options.new)
    return _done(f"{options.name} is now {options.new}")


def delete(options: argparse.Namespace) -> Result:
    """Delete a point or a sequence."""
    _, book = chosen_points(options)
    taught = book.read()
    if options.name in taught.sequences:
        book.remove_sequence(options.name, instead_of=taught.sequences[options.name])
    else:
        del book[options.name]
    return _done(f"{options.name} is deleted")


def _done(text: str) -> Result:
    return Result({"done": text}, text)


def _steps_view(steps: StepList) -> dict[str, Any]:
    return {"note": steps.note, "steps": [str(step) for step in steps.steps]}
