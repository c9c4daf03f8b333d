"""What is remembered of a running arm: when its record is written, and the mark of motion.

Everything here only *asks* for writing and returns at once (storage/record_writer.py does it).
Whoever must not go on before the mark is on the disk waits until `mark_stands` (motion/context.py).
"""

from __future__ import annotations

from collections.abc import Callable

from armdrive.errors import StateFileError
from armdrive.status import Trust
from armdrive.storage.record import NoRecorder, PositionRecorder, Record
from armdrive.storage.record_writer import AtOnce, BesideTheWire, Keeper, RecordWriter


class Memory:
    """One arm's record. `describe(in_motion)` gives the record of this moment.

    Nothing is written before `taken_up`: a connection that failed leaves the record as it was.
    With `wake` the writing is done in a thread beside the caller's, and `wake` is called after it.
    """

    def __init__(
        self,
        recorder: PositionRecorder | None,
        describe: Callable[[bool], Record],
        wake: Callable[[], None] | None = None,
    ) -> None:
        self._recorder = recorder or NoRecorder()
        self._describe = describe
        self._keeper = Keeper(self._recorder)
        self._writer: RecordWriter = AtOnce(self._keeper)
        if wake is not None and not isinstance(self._recorder, NoRecorder):
            self._writer = BesideTheWire(self._keeper, wake)
        self._taken_up = False
        self._moving = False
        self._asked: Record | None = None
        self._asked_number = 0
        self._cleared_number = 0
        self._told_number = 0

    # -- what an earlier program left ---------------------------------------------------------

    def load(self, arm: str, calibration: str, motors: int) -> Record | None:
        """Return what an earlier program left; raises `StateFileError` where it is of no use."""
        try:
            record = self._recorder.load()
            if record is None:
                return None
            record.require_owner(arm, calibration, motors)
        except StateFileError:
            self._keeper.refused()
            raise
        self._keeper.found(record)
        return record

    def taken_up(self) -> None:
        """From here on the record is this program's to write."""
        self._taken_up = True

    # -- the mark of motion -------------------------------------------------------------------

    def begin_mark(self) -> None:
        """Ask for the mark of motion, unless it stands already."""
        self._moving = True
        if not self._mark_is_kept:
            self._ask()

    def mark_stands(self) -> bool:
        """Tell whether the mark outlives a power cut by now.

        Raises `StateFileError` where it could not be written: then nothing may move, since a
        program that ended in mid-motion would leave a wrong position behind.
        """
        if self._mark_is_kept:
            return True
        outcome = self._writer.outcome
        if outcome.number < self._asked_number:
            return False
        self._moving = False
        raise StateFileError(self._words(outcome.error))

    def mark_still(self) -> None:
        """Ask for the position of an arm that stands, without the mark."""
        self._moving = False
        self._ask()

    @property
    def owing(self) -> bool:
        """Whether the mark may still be there, or what was asked for last could not be written."""
        kept = self._writer.outcome.kept
        return self._moving or self._failed or (kept is not None and kept.in_motion)

    @property
    def _mark_is_kept(self) -> bool:
        """A mark is on the disk, and nothing has been asked for since that takes it away."""
        outcome = self._writer.outcome
        marked = outcome.kept is not None and outcome.kept.in_motion
        return marked and outcome.kept_number > self._cleared_number

    # -- whatever else is to be remembered ----------------------------------------------------

    def remember(self) -> None:
        """Ask for what is believed now; a mark of motion stays."""
        self._ask()

    @property
    def settled(self) -> bool:
        """Whether nothing is left to write: it is on the disk, or has failed."""
        return self._writer.outcome.number >= self._asked_number

    def trouble(self) -> str:
        """Return why the position could not be remembered, once for each time; or nothing."""
        outcome = self._writer.outcome
        if outcome.number == self._told_number:
            return ""
        self._told_number = outcome.number
        return self._words(outcome.error) if outcome.error else ""

    def finish(self, timeout_s: float) -> None:
        """Wait until all is written. Nothing is written afterwards, not even by a slow disk."""
        self._writer.finish(timeout_s)
        self._keeper.end()

    def _ask(self) -> None:
        """Hand over the record of this moment, unless it is the last one's, or there is none."""
        record = self._describe(self._moving)
        nothing_known = record.trust == Trust.UNKNOWN.value and not self._moving
        if not self._taken_up or (record == self._asked and not self._failed):
            return
        if nothing_known and self._asked is None:
            return  # an unusable record is left as it is until the arm has moved
        self._asked = record
        self._asked_number = self._writer.put(record)
        if not record.in_motion:
            self._cleared_number = self._asked_number

    @property
    def _failed(self) -> bool:
        outcome = self._writer.outcome
        return bool(outcome.error) and outcome.number >= self._asked_number

    def _words(self, error: str) -> str:
        return (
            f"the position of {self._describe(self._moving).arm} cannot be remembered ({error}): "
            "make room on the disk, or the folder writable"
        )
