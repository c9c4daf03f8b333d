"""Saved points of an arm: list and edit them, derive new ones, export a sequence as a program."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import armdrive.programs as programs
from armdrive.cli.arm_files import chosen_points
from armdrive.cli.presenter import Result
from armdrive.config.arm import ArmConfig
from armdrive.errors.printable import command_line
from armdrive.programs.teaching.export import program_of
from armdrive.programs.teaching.shape import Offset, Reshape, mirrored, offset
from armdrive.status import pose_view
from armdrive.storage.files import require_free, write_named
from armdrive.storage.points import StepList, Taught, check_name, point_view
from kinematics.text import counted

# -- the file of points ---------------------------------------------------------------------------


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


# -- new points and sequences from old ones ----------------------------------------------------


def shape(options: argparse.Namespace) -> Result:
    """Derive new points and sequences, check every one, and write all or none."""
    config, book = chosen_points(options)
    new = check_name(options.new)
    made = _change(options, config).taught(options.name, new, book.read())
    book.put_all(made.points, made.sequences, again=options.again)
    lines = [f"{name}: {point.joints}" for name, point in made.points.items()]
    lines += [
        f"{name}: sequence of {counted(len(each.steps), 'step')}"
        for name, each in made.sequences.items()
    ]
    view = {"name": new, "points": list(made.points), "sequences": list(made.sequences)}
    return Result(view, lines)


def _change(options: argparse.Namespace, config: ArmConfig) -> Reshape:
    if options.action == "copy":
        return Reshape(config, lambda joints: joints)
    if options.action == "mirror":
        return Reshape(config, partial(mirrored, config), f"{options.name} mirrored")
    by = Offset(options.x, options.y, options.z, math.radians(options.turn))
    shape = partial(offset, config, by=by)
    return Reshape(config, shape, f"{options.name} offset by {by}")


# -- a sequence as a program ---------------------------------------------------------------------


def export(options: argparse.Namespace) -> Result:
    """Write the program to a file, which may exist only with --force."""
    path = Path(options.file)
    require_free(path, overwrite=options.force)
    config, book = chosen_points(options)
    steps, taught = book.sequence(options.name), book.read()
    tree = program_of(options.name, steps, taught.points, config.model.arm.fk)
    program = programs.written_program(tree, str(path))
    write_named(path, program.text.encode("utf-8"))
    return Result(
        {"file": str(path), "sha256": program.digest, "steps": len(steps.steps)},
        f"{options.name} is now {path}; `{command_line('run', path, '--check')}` rehearses it",
    )
