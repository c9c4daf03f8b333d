"""The last resort: an error that nobody foresaw becomes one sentence, and a file with the details.

Such an error is a fault of armdrive itself. A person can do nothing with its traceback, and text
in it may come from a file or a device. `ARMDRIVE_TRACEBACK=1` in the environment lets it through,
for tests and for whoever looks for the fault: runner.py, which loads this module when it needs it.
"""

from __future__ import annotations

import sys
import traceback
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from armdrive.errors.printable import printable_lines, shortened
from armdrive.storage import files as places
from armdrive.storage.files import replace_file

DETAILS = "unexpected.txt"
"""The file of the last fault, in the state folder."""

MOST_LINES = 400
"""Lines of a traceback that are kept. One of an endless recursion has thousands that are alike."""

_MOST_REASON = 200  # characters: an unforeseen error may quote a whole file


class Unexpected(Exception):
    """An error that nobody foresaw; making it writes the details down."""

    def __init__(self, error: BaseException) -> None:
        reason = shortened(f"{type(error).__name__}: {error}".split("\n")[0], _MOST_REASON)
        super().__init__(
            f"armdrive itself failed ({reason}). {_written(error)}; "
            "please report it with what you did"
        )


def _written(error: BaseException) -> str:
    """Write the details down; return the words that say where they are."""
    path = places.states() / DETAILS
    try:
        replace_file(path, _details(error))
    except (OSError, ValueError) as refusal:
        reason = getattr(refusal, "strerror", None) or refusal
        return (
            f"The details could not be written to {path} ({reason}): "
            "ARMDRIVE_TRACEBACK=1 shows them"
        )
    return f"The details are in {path}"


def _details(error: BaseException) -> str:
    """Return what to report: when, which version, which command, and the traceback."""
    lines = "".join(traceback.format_exception(error, chain=True)).splitlines()
    if len(lines) > MOST_LINES:
        half = MOST_LINES // 2
        lines = [*lines[:half], "...", *lines[-half:]]
    words = " ".join(shortened(repr(word), _MOST_REASON) for word in sys.argv[1:])
    heading = [
        f"time: {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"armdrive: {version('armdrive')}, Python {sys.version.split()[0]}, {sys.platform}",
        f"command: {Path(sys.argv[0]).name} {words}",
    ]
    return printable_lines("\n".join([*heading, "", *map(shortened, lines)]))
