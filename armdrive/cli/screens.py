"""The terminal that a command runs in: whether a screen can be drawn there, and a yes or a no."""

from __future__ import annotations

import os
import sys

from armdrive.cli.presenter import put
from armdrive.errors import BadRequest

WITHOUT_SCREEN = ("dumb", "unknown")
"""What `TERM` says of terminals that only print line after line: the framework draws nothing there,
and a desk that nobody sees would hold an arm.
"""


def require_screen(what: str, otherwise: str) -> None:
    """Raise `BadRequest` unless a person can see a screen here, saying what does without one."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise BadRequest(f"{what} needs a terminal; {otherwise}")
    kind = os.environ.get("TERM", "")
    if kind.lower() in WITHOUT_SCREEN:
        raise BadRequest(
            f"{what} needs a terminal that draws, and this one says TERM={kind}; {otherwise}. "
            "Where it does draw, say so: TERM=xterm-256color armdrive ..."
        )


def agreed(question: str) -> bool:
    """Ask a question at the terminal; anything but a yes is a no."""
    if not sys.stdin.isatty():
        return False
    put(question)
    return sys.stdin.readline().strip().lower() in ("yes", "y")
