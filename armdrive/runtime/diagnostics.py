"""What the status says beside its numbers: an error and a notice, each with its code.

Words that are put down without a code have none: words and code never come apart.
"""

from __future__ import annotations

from armdrive.errors.table import entry, entry_of, named
from armdrive.status import Evidence

FAULT = named("DeviceFault").code
"""The code of a fault that is reported in words alone."""

EMERGENCY_STOP = named("EMERGENCY_STOP").code
RECONNECTED = named("RECONNECTED").code
ALARM_VOUCHED = named("ALARM_VOUCHED").code


def code_of(cause: BaseException | Evidence) -> str:
    """Return the code of an error or of an evidence; empty where it has none."""
    row = entry_of(cause) if isinstance(cause, Evidence) else entry(cause)
    return "" if row is None else row.code


class Diagnostics:
    """The error and the notice of one arm."""

    def __init__(self) -> None:
        self._error = self._notice = ("", "")

    @property
    def error(self) -> str:
        """Why the arm is in error-stop, or why its wire is lost."""
        return self._error[0]

    @error.setter
    def error(self, words: str) -> None:
        self._error = (words, "")

    @property
    def error_code(self) -> str:
        """The catalogue's code of the error."""
        return self._error[1]

    @property
    def notice(self) -> str:
        """What somebody should know."""
        return self._notice[0]

    @notice.setter
    def notice(self, words: str) -> None:
        self._notice = (words, "")

    @property
    def notice_code(self) -> str:
        """The catalogue's code of the notice, where it is about something that went wrong."""
        return self._notice[1]

    def say_error(self, words: str, code: str) -> None:
        """Put an error down with its code."""
        self._error = (words, code)

    def notify(self, words: str, cause: BaseException | Evidence) -> None:
        """Put a notice down with the code of its cause."""
        self._notice = (words, code_of(cause))
