"""Run a program: a program file (.arm) or a Python script (.py), rehearsed or for good."""

from __future__ import annotations

import argparse
from pathlib import Path

from armdrive.cli.program.arguments import PROGRAM, SCRIPT
from armdrive.cli.program.run_script import run_script
from armdrive.errors import BadRequest
from armdrive.render.sketch import check_output


def run(options: argparse.Namespace) -> int:
    """Run or rehearse the program."""
    if options.plot is not None:
        options.check = True
        _check_plot(options.plot)
    ending = options.program.suffix.lower()
    if ending == PROGRAM:
        if options.words:
            raise BadRequest(f"a program file takes no arguments: {' '.join(options.words)}")
        # the language's parser takes as long to import as all that a script needs
        from armdrive.cli.program.run_program import run_program

        return run_program(options)
    if ending == SCRIPT:
        return run_script(options)
    raise BadRequest(f"{options.program} is no program: one ends in {PROGRAM} or {SCRIPT}")


def _check_plot(output: str) -> None:
    if output:
        check_output(Path(output))
