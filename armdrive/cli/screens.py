"""The terminal that a command runs in: whether it can draw, and what a person types."""

from __future__ import annotations

import os
import sys

from armdrive.cli.presenter import WITHOUT_SCREEN, put
from armdrive.errors import BadRequest


def require_screen(what: str, otherwise: str) -> None:
    """Raise `BadRequest` if the terminal cannot draw; `otherwise` names what works without."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise BadRequest(f"{what} needs a terminal; {otherwise}")
    kind = os.environ.get("TERM", "")
    if kind.lower() in WITHOUT_SCREEN:
        raise BadRequest(
            f"{what} needs a terminal that can draw, and this one has TERM={kind}; {otherwise}. "
            "If it can draw after all, use: TERM=xterm-256color armdrive ..."
        )


def typed(prompt: str) -> str | None:
    """Return the next line of the input, from the terminal or a pipe; None at its end."""
    put(prompt)
    line = sys.stdin.readline()
    if not line:
        put("\n")  # the next text starts on a new line, not after the prompt
        return None
    return line.strip()


def agreed(question: str) -> bool:
    """Ask a question at the terminal; any answer but yes means no."""
    if not sys.stdin.isatty():
        return False
    answer = typed(question)
    return answer is not None and answer.lower() in ("yes", "y")
