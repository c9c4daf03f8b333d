"""The program that an arm keeps in its own memory, for its pendant: into a file, and back."""

from __future__ import annotations

import argparse
from datetime import datetime
from pathlib import Path

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import Result, agreed, as_json, say
from armdrive.cli.terminal_operator import ready_arm
from armdrive.config.arm import ArmConfig
from armdrive.errors import OperatorNeeded, PendantFileError
from armdrive.registry import pendant_of
from armdrive.registry.pendant import PendantProgram
from armdrive.status import BELIEVED
from armdrive.storage.files import require_free, write_named
from armdrive.text.reading import read_text
from kinematics.text import counted


def _read_from(options: argparse.Namespace) -> tuple[ArmConfig, PendantProgram]:
    with ready_arm(options) as arm:
        return arm.config, arm.controller.read_program()


def show(options: argparse.Namespace) -> Result:
    """Print the program in the arm."""
    config, program = _read_from(options)
    lines = text_of(config, program).rstrip("\n").split("\n")
    return Result(program.view(config), lines)


def read(options: argparse.Namespace) -> Result:
    """Read the program out of the arm into a file."""
    path = Path(options.file)
    require_free(path, overwrite=options.force)
    config, program = _read_from(options)
    into_file(path, config, program)
    view = {"file": str(path), **program.view(config)}
    return Result(view, f"{counted(len(program.rows), 'row is', 'rows are')} in {path} now")


def write(options: argparse.Namespace) -> Result:
    """Write a file's rows into the arm."""
    program = from_file(Path(options.file), chosen_target(options).config)
    with ready_arm(options) as arm:
        if options.as_is:
            program = program.without_origin()
        if options.shift:
            program = program.moved_to(arm.controller.read_program().origin)
        count = len(program.rows)
        if not options.yes and (as_json(options) or not agreed(_question(arm, program))):
            raise OperatorNeeded(
                "not confirmed, nothing was written: add --yes to write without asking"
            )
        written = arm.controller.write_program(program, leave_others=options.leave_others)
    summary = (
        f"{counted(count, 'row is', 'rows are')} in the arm: {written} written, and "
        "all read back as they should"
    )
    return Result({"rows": count, "written": written}, summary)


def _question(arm: Arm, program: PendantProgram) -> str:
    known = arm.status.trust in BELIEVED
    if program.origin is not None and not known:
        say("This arm was not homed: its rows may lead elsewhere than when they were read.")
    return (
        f"Write {counted(len(program.rows), 'row')} into the memory of {arm.status.arm}? "
        "Nothing moves. yes: "
    )


# Files of a pendant's program.


def from_file(path: Path, config: ArmConfig) -> PendantProgram:
    """Read a file; raises `PendantFileError` that names it and the line."""
    pendant = pendant_of(config)
    text = read_text(path, "the file", PendantFileError, most_bytes=pendant.LARGEST_BYTES)
    try:
        return pendant.parse(text)
    except PendantFileError as error:
        raise PendantFileError(f"{path}: {error}") from None


def into_file(path: Path, config: ArmConfig, program: PendantProgram) -> None:
    """Write a file; raises `OSError`, and `PendantFileError` where it would read otherwise."""
    text = text_of(config, program)
    if program.parse(text) != program:
        raise PendantFileError("what was read does not fit into a file: nothing was written")
    write_named(path, text.encode("utf-8"))


def text_of(config: ArmConfig, program: PendantProgram) -> str:
    """Return a program as a file has it, with what each row means on this arm."""
    return program.text(config, f"{datetime.now():%Y-%m-%d %H:%M}")
