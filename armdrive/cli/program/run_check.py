"""Rehearses a Python script, and reports what it would do."""

from __future__ import annotations

import argparse
import contextlib
import sys
from typing import Any

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import put_error
from armdrive.cli.program.run_common import connect_to_check, slow_down
from armdrive.cli.program.run_report import report
from armdrive.errors import ArmError, BadRequest
from armdrive.programs.rehearsal import Rehearsal, RehearsedPlan
from armdrive.programs.script_rehearsal import rehearse_script
from armdrive.programs.scripts import own_traceback
from kinematics.errors import KinematicsError


def check_script(options: argparse.Namespace, lines: list[str]) -> int:
    """Rehearse a script on the arm that the options name, and report what was found."""
    arm, unasked = connect_to_check(options)
    with contextlib.closing(arm) if arm is not None else contextlib.nullcontext():
        plan = RehearsedPlan(
            _NoSource(),
            inputs=dict(options.input),
            width_mm=options.assume_width,
            settle=True,
            traced=options.plot is not None,
        )
        config = chosen_target(options).config
        if arm is not None:
            slow_down(arm, options)
        output = contextlib.redirect_stdout(sys.stderr) if options.json else None
        with output or contextlib.nullcontext():
            rehearsal = rehearse_script(options.program, options.words, config, arm, plan)
        if (code := _own_error(rehearsal, options)) is not None:
            return code
        return report(rehearsal, options, lines, unasked)


def _own_error(rehearsal: Rehearsal, options: argparse.Namespace) -> int | None:
    """Show the traceback of an error that is the script's own; return what it ends with."""
    error = rehearsal.refusal
    if error is None or isinstance(error, ArmError | KinematicsError):
        return None
    put_error(own_traceback(error, options.program))
    return 1


class _NoSource:
    """A script has no machine: it runs by itself."""

    def machine(self) -> Any:
        """Refuse."""
        raise BadRequest("a Python script has no acts")
