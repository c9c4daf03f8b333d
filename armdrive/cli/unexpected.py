"""Turns an unexpected error into one sentence, and saves the details in a file.

Such an error is a fault of armdrive itself. Its traceback does not help a user, and may contain
text from a file or a device. With `ARMDRIVE_TRACEBACK=1` in the environment, runner.py lets the
traceback through, for tests and for debugging.
"""

from __future__ import annotations

import sys
import traceback
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from armdrive.errors import StateFileError
from armdrive.errors.printable import printable_lines, reason_of, shortened
from armdrive.storage import files as places
from armdrive.storage.files import replace_file

# The file with the details of the last fault, in the state folder.
DETAILS = "unexpected.txt"

_MOST_REASON = 200  # characters: the message may quote a whole file


class Unexpected(Exception):
    """A fault of armdrive itself; creating the exception saves the details."""

    def __init__(self, error: BaseException) -> None:
        reason = shortened(f"{type(error).__name__}: {error}".split("\n")[0], _MOST_REASON)
        super().__init__(
            f"armdrive itself failed ({reason}). {_written(error)}; "
            "please report it with what you did"
        )


def _written(error: BaseException) -> str:
    """Save the details; return the sentence that says where."""
    try:
        path = places.states() / DETAILS
        replace_file(path, _details(error))
    except (OSError, ValueError, StateFileError) as refusal:
        reason = reason_of(refusal)
        return f"The details could not be written ({reason}): ARMDRIVE_TRACEBACK=1 shows them"
    return f"The details are in {path}"


def _details(error: BaseException) -> str:
    """Return the details: time, version, command and traceback."""
    lines = "".join(traceback.format_exception(error)).splitlines()
    words = " ".join(shortened(repr(word), _MOST_REASON) for word in sys.argv[1:])
    heading = [
        f"time: {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"armdrive: {version('armdrive')}, Python {sys.version.split()[0]}, {sys.platform}",
        f"command: {Path(sys.argv[0]).name} {words}",
    ]
    return printable_lines("\n".join([*heading, "", *map(shortened, lines)]))
