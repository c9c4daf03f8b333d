"""What is remembered of a running arm: when its record is written, and the mark of motion."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.errors import StateFileError
from armdrive.record import Record, Recorder
from armdrive.status import Trust


class Memory:
    """Writes one arm's record. `describe(in_motion)` gives the record of this moment.

    Nothing is written before `taken_up`: a connection that failed leaves the record as it was.
    """

    def __init__(self, recorder: Recorder, describe: Callable[[bool], Record]) -> None:
        self._recorder = recorder
        self._describe = describe
        self._taken_up = False
        self._marked = False
        self._saved: Record | None = None

    @property
    def marked(self) -> bool:
        """Tell whether the mark of motion stands in the record."""
        return self._marked

    def load(self) -> Record | None:
        """Return what an earlier program left; raises `StateFileError`."""
        return self._recorder.load()

    def taken_up(self) -> None:
        """From here on the record is this program's to write."""
        self._taken_up = True

    def mark_leaving(self) -> None:
        """Write the mark of motion, once, before the arm leaves stand-still.

        Raises `StateFileError` where that is not possible: then nothing may move, since a
        program that ended in mid-motion would leave a wrong position behind.
        """
        if self._marked:
            return
        self._marked = True
        try:
            self._save()
        except StateFileError:
            self._marked = False
            raise

    def mark_still(self) -> str:
        """Take the mark away if that can be written; return why not, or nothing."""
        marked, self._marked = self._marked, False
        trouble = self.save_if_possible()
        if trouble:
            self._marked = marked
        return trouble

    def save_if_possible(self) -> str:
        """Write the record; return why that was not possible, or nothing."""
        try:
            self._save()
        except StateFileError as error:
            return str(error)
        return ""

    def _save(self) -> None:
        """Write the record, unless there is none yet and nothing to be remembered."""
        record = self._describe(self._marked)
        nothing_known = record.trust == Trust.UNKNOWN.value and not self._marked
        if not self._taken_up or record == self._saved:
            return
        if nothing_known and self._saved is None:
            return  # an unusable record is left as it is until the arm has moved
        try:
            self._recorder.save(record)
        except OSError as error:
            raise StateFileError(
                f"the position of {record.arm} cannot be remembered ({error}): make room on the "
                "disk, or the folder writable"
            ) from None
        self._saved = record
