"""Teach a program: record it as another program moves the arm."""

from __future__ import annotations

import argparse
import re
import time

from armdrive.cli.chosen_arm import held_config
from armdrive.cli.holders import one_holder
from armdrive.cli.presenter import Result, show, tell
from armdrive.errors import BadRequest, Refused
from armdrive.errors.printable import command_line
from armdrive.programs.program import program_path
from armdrive.programs.teaching import Choices, ProgramRecorder, seen_in
from armdrive.storage.files import require_free, write_named
from armdrive.storage.lock_client import watch_holder
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import check_name
from kinematics.text import counted

LOOK_EVERY_S = 0.1  # eight looks within the usual rest, `REST_S`


def record(options: argparse.Namespace) -> Result:
    """Record until Ctrl-C, or until the arm is given back.

    Every line is written at once, so that no way to end loses any.
    """
    path = program_path(options.program, "armdrive teach stack.arm")
    require_free(path, overwrite=options.force)
    recorder = ProgramRecorder(
        point_prefix(path.stem),
        Choices(options.line, options.speed, options.waits, options.rest),
    )
    name = one_holder(options)
    config = held_config(options, name)
    book = points_of(config.name, config.model.arm)
    require_free_points(book, recorder.name, overwrite=options.force)
    tell(options, f"recording {name} into {path}: a line wherever it comes to rest; Ctrl-C ends it")
    written = ""

    def keep() -> None:
        nonlocal written
        book.put_all(recorder.points, again=True)
        write_named(path, recorder.text.encode("utf-8"))
        for line in recorder.text.removeprefix(written).splitlines():
            show(Result({"text": line}, line), options)
        written = recorder.text

    try:
        for view in watch_holder(name, LOOK_EVERY_S):
            if view["state"] == "disconnected":
                break
            seen = seen_in(view, config.model.arm.joint_names)
            if recorder.see(seen, time.monotonic()):
                keep()
    except KeyboardInterrupt:  # how a recording ends
        pass
    finally:
        if recorder.end(time.monotonic()):
            keep()
    if not written:
        raise Refused("nothing was recorded: the arm was never seen at rest")
    count = f"{counted(len(recorder.points), 'point')}, in {book.path}"
    return Result(None, f"{count}; `{command_line('run', path, '--check')}` rehearses {path}")


def point_prefix(stem: str) -> str:
    """Return what the points of a taught program begin with, by the name of its file."""
    return check_name(re.sub(r"\W", "_", stem))


def require_free_points(book: Points, prefix: str, *, overwrite: bool) -> None:
    """Raise `BadRequest` if points of a taught program exist already, before anything is made."""
    taken = [name for name in book if re.fullmatch(f"{prefix}_[0-9]+", name)]
    if taken and not overwrite:
        raise BadRequest(
            f"there is {', '.join(taken)} already: name the program otherwise, or add --force"
        )
