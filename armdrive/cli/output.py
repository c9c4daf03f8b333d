"""Printing for people and for programs: sentences, or one JSON document a line."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Any

from armdrive.catalogue.actions import COMMAND_LINE, presented

if TYPE_CHECKING:
    from armdrive.status import Status


def say(text: str) -> None:
    """Print a line, in the words of the command line."""
    sys.stdout.write(f"{presented(text, COMMAND_LINE)}\n")
    sys.stdout.flush()


def complain(text: str) -> None:
    """Print a line on the error output, in the words of the command line."""
    sys.stderr.write(f"{presented(text, COMMAND_LINE)}\n")
    sys.stderr.flush()


def emit(document: dict[str, Any]) -> None:
    """Print a JSON document on a line of its own."""
    say(json.dumps(document))


def say_which(status: Status) -> None:
    """Say which arm this is; every command that touches one begins with it."""
    say(status.which)
