"""The last resort: an error that nobody foresaw becomes one sentence, and a file with the details.

Such an error is a fault of armdrive itself. A person can do nothing with its traceback, and text
in it may come from a file or a device. `ARMDRIVE_TRACEBACK=1` in the environment lets it through,
for tests and for whoever looks for the fault.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import traceback
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from armdrive.cli.presenter import complain
from armdrive.errors.printable import printable_lines, shortened
from armdrive.errors.table import tagged
from armdrive.storage import files as places
from armdrive.storage.files import replace_file

FAULT = 70
"""The exit code, which sysexits.h calls EX_SOFTWARE: an internal error."""

DETAILS = "unexpected.txt"
"""The file of the last fault, in the state folder."""

MOST_LINES = 400
"""Lines of a traceback that are kept. One of an endless recursion has thousands that are alike."""

_RAISES = "ARMDRIVE_TRACEBACK"
_MOST_REASON = 200  # characters: an unforeseen error may quote a whole file


class Unexpected(Exception):
    """An error that nobody foresaw; making it writes the details down."""

    def __init__(self, error: BaseException) -> None:
        reason = shortened(f"{type(error).__name__}: {error}".split("\n")[0], _MOST_REASON)
        super().__init__(
            f"armdrive itself failed ({reason}). {_written(error)}; "
            "please report it with what you did"
        )


def raises_unexpected() -> bool:
    """Tell whether the environment asks for the exception itself."""
    return os.environ.get(_RAISES, "") not in ("", "0")


@contextlib.contextmanager
def threads_told() -> Iterator[None]:
    """Have an unforeseen error in a thread told in the same way while a command runs."""
    if raises_unexpected():
        yield
        return
    before = threading.excepthook
    threading.excepthook = _tell_of_thread
    try:
        yield
    finally:
        threading.excepthook = before


def _tell_of_thread(found: threading.ExceptHookArgs) -> None:
    if found.exc_value is not None and not isinstance(found.exc_value, SystemExit):
        with contextlib.suppress(OSError, ValueError):  # the error output is closed
            complain(f"armdrive: {tagged(Unexpected(found.exc_value))}")


def _written(error: BaseException) -> str:
    """Write the details down; return the words that say where they are."""
    path = places.states() / DETAILS
    try:
        replace_file(path, _details(error))
    except (OSError, ValueError) as refusal:
        reason = getattr(refusal, "strerror", None) or refusal
        return f"The details could not be written to {path} ({reason}): {_RAISES}=1 shows them"
    return f"The details are in {path}"


def _details(error: BaseException) -> str:
    """Return what to report: when, which version, which command, and the traceback."""
    from importlib.metadata import version  # slow to import, and hardly ever needed

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
