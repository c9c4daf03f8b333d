"""`armdrive points export`: a taught sequence as a program file."""

from __future__ import annotations

import argparse
from pathlib import Path

import armdrive.programs as programs
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import emit, say
from armdrive.errors import BadRequest
from armdrive.programs.teaching.export import program_of
from armdrive.storage.files import DISK, replace_durably
from armdrive.storage.point_file import points_of


def export(options: argparse.Namespace) -> int:
    """Write the program beside nothing that is there, unless told to, and say where."""
    path = Path(options.file)
    if path.exists() and not options.force:
        raise BadRequest(f"{path} is there already: name another file, or say --force")
    config = chosen_target(options).config
    book = points_of(config.name, config.model.arm)
    steps, taught = book.sequence(options.name), book.read()
    tree = program_of(options.name, steps, taught.points, config.model.arm.fk)
    program = programs.written_program(tree, str(path))
    replace_durably(DISK, path.absolute(), program.text.encode("utf-8"))
    if options.json:
        emit({"file": str(path), "sha256": program.digest, "steps": len(steps.steps)})
    else:
        say(f"{options.name} is {path} now: `armdrive run {path} --check` tells what it would do")
    return 0
