"""Write what the flight recorder of an arm holds: the program that drives the arm does it."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from armdrive.cli.control_requests import chosen_holders
from armdrive.cli.presenter import emit, say
from armdrive.errors import ArmError, BadRequest
from armdrive.storage.lock_client import ask_holder


def run(options: argparse.Namespace) -> int:
    """Ask the holders to write, and say which files they wrote."""
    names = chosen_holders(options)
    if not names:
        raise ArmError("no program of yours holds an arm: there is nothing to be written")
    if options.output is not None and len(names) > 1:
        raise BadRequest(f"several arms are held ({', '.join(names)}): name the one for --output")
    files = [_recorded(name) for name in names]
    if options.output is not None:
        files = [Path(shutil.copyfile(files[0], options.output))]
    for file in files:
        if options.json:
            emit({"recording": str(file)})
        else:
            say(f"written: {file}")
    return 0


def _recorded(name: str) -> Path:
    answer = ask_holder(name, "record")
    if "recording" not in answer:
        raise ArmError(f"{name} was not recorded: {answer.get('error', 'no reason was given')}")
    return Path(str(answer["recording"]))
