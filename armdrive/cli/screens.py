"""The terminal that a command runs in: whether a screen can be drawn there, and what is typed."""

from __future__ import annotations

import os
import sys

from armdrive.cli.presenter import WITHOUT_SCREEN, put
from armdrive.errors import BadRequest


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


def typed(prompt: str) -> str | None:
    """Return the next line of the input, from the terminal or a pipe; None where it has ended."""
    put(prompt)
    line = sys.stdin.readline()
    if not line:
        put("\n")  # what is said next does not stand behind the prompt
        return None
    return line.strip()


def agreed(question: str) -> bool:
    """Ask a question at the terminal; anything but a yes is a no."""
    if not sys.stdin.isatty():
        return False
    answer = typed(question)
    return answer is not None and answer.lower() in ("yes", "y")
