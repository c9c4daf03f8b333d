"""`armdrive pendant points` and `make`: from a pendant's rows to taught points, and back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.cli.chosen_arm import chosen_target
from armdrive.cli.pendant_files import from_file, into_file
from armdrive.cli.presenter import emit, say

if TYPE_CHECKING:
    import argparse

    from armdrive.arm import Arm


def make_points(options: argparse.Namespace) -> int:
    """Make points and a sequence of a file's rows; the arm need not be there."""
    from armdrive.dialects.teachmover.pendant import taught_by
    from armdrive.storage.point_file import points_of

    config = chosen_target(options).config
    program = from_file(Path(options.file))
    note = f"from the arm's own program, {Path(options.file).name}"
    points, steps = taught_by(config, program, options.name, note)
    book = points_of(config)
    book.put_all(points, {options.name: steps}, again=options.again)
    if options.json:
        emit({"sequence": options.name, "points": list(points), "steps": len(steps.steps)})
    else:
        say(f"{options.name}: {len(steps.steps)} steps over {len(points)} points, in {book.path}")
    return 0


def make_rows(options: argparse.Namespace, arm: Arm) -> int:
    """Make a file of rows of a sequence, as the arm's registers count now."""
    from armdrive.programs.teaching.pendant_program import rows_of

    steps, taught = arm.points.sequence(options.name), arm.points.read()
    origin = arm.read_pendant_program().origin
    program = rows_of(arm.config, steps, taught.points, origin)
    into_file(Path(options.file), arm.config, program)
    if options.json:
        emit({"file": options.file, "rows": len(program.rows)})
    else:
        say(f"{options.name} is {len(program.rows)} rows in {options.file} now")
    return 0
