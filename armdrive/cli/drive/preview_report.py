"""A move on the command line: carried out, or shown as it would be."""

from __future__ import annotations

import argparse

from armdrive.arm import Arm
from armdrive.cli.presenter import emit, say
from armdrive.errors import Refused
from armdrive.motion.preview import Preview, preview_lines, preview_view
from armdrive.moves import Motion, MoveSequence
from armdrive.status import status_view


def show_preview(preview: Preview, *, as_json: bool) -> int:
    """Print a preview; return the code that the motion itself would end with, 0 where it may go."""
    if as_json:
        emit(preview_view(preview))
    else:
        for line in preview_lines(preview):
            say(line)
    if preview.refusal is None:
        return 0
    return getattr(preview.refusal, "exit_code", Refused.exit_code)


def run_move(arm: Arm, move: Motion | MoveSequence, options: argparse.Namespace) -> int:
    """Carry a move out and say what it did, or with --preview what it would be."""
    if options.preview:
        return show_preview(arm.preview(move), as_json=options.json)
    moved = arm.run(move)
    if options.json:
        emit(status_view(arm.status))
    else:
        say(str(moved))
    return 0
