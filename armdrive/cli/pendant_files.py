"""Files of a pendant's program, as the command line reads and writes them."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING

from armdrive.errors import BadRequest, PendantFileError
from armdrive.storage.files import DISK, replace_durably
from armdrive.text.reading import read_text

if TYPE_CHECKING:
    from pathlib import Path

    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.teachmover.pendant import PendantProgram


def from_file(path: Path) -> PendantProgram:
    """Read a file; raises `PendantFileError` that names it and the line."""
    from armdrive.dialects.teachmover.pendant import LARGEST_BYTES, parse_pendant

    text = read_text(path, "the file", PendantFileError, most_bytes=LARGEST_BYTES)
    try:
        return parse_pendant(text)
    except PendantFileError as error:
        raise PendantFileError(f"{path}: {error}") from None


def into_file(path: Path, config: ArmConfig, program: PendantProgram) -> None:
    """Write a file; raises `OSError`, and `PendantFileError` where it would read otherwise."""
    from armdrive.dialects.teachmover.pendant import parse_pendant

    text = text_of(config, program)
    if parse_pendant(text) != program:
        raise PendantFileError("what was read does not fit into a file: nothing was written")
    replace_durably(DISK, path.absolute(), text.encode("utf-8"))


def require_free(path: Path, *, force: bool) -> None:
    """Raise `BadRequest` where a file is there already, before anything is asked of an arm."""
    if path.exists() and not force:
        raise BadRequest(f"{path} is there already: name another file, or say --force")


def text_of(config: ArmConfig, program: PendantProgram) -> str:
    """Return a program as a file has it, with what each row means on this arm."""
    from armdrive.dialects.teachmover.pendant import meaning, pendant_text

    transmission = config.model.transmission
    names = [motor.name for motor in transmission.motors] if transmission else []
    when = f"{datetime.now():%Y-%m-%d %H:%M}"
    meanings = [meaning(config, program, row) for row in program.rows]
    return pendant_text(program, config.name, when, names, meanings)
