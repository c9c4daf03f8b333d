"""Printing a preview, and the exit code of a motion that would be refused."""

from __future__ import annotations

from armdrive.cli.presenter import emit, say
from armdrive.errors import Refused
from armdrive.motion.preview import Preview, preview_lines, preview_view


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
