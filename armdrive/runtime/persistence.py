"""When an arm's position record is written, and the motion mark in it.

The motion mark says that the arm is moving: if a program dies during a motion, the next program
finds the mark and does not trust the recorded position. The methods here only request a write and
return at once (storage/record.py writes). A motion waits for `mark_stands` before its first
byte (motion/context.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable

from armdrive.errors import StateFileError
from armdrive.status import Trust
from armdrive.storage.record import Record, RecordStore, RecordWriter

# After this long at rest, remove the motion mark. Short stops do not write to the disk twice.
STILL_S = 2.0


class Memory:
    """The position record of one arm. `describe(in_motion)` returns the present record.

    Nothing is written before `taken_up`, so a failed connection leaves the record as it was. With
    `wake`, another thread writes and then calls `wake`.
    """

    def __init__(
        self,
        store: RecordStore,
        describe: Callable[[bool], Record],
        wake: Callable[[], None] | None,
    ) -> None:
        self._store = store
        self._describe = describe
        self._writer = RecordWriter(store, wake)
        self._taken_up = False
        self._moving = False
        self._asked: Record | None = None
        self._asked_number = 0
        self._cleared_number = 0
        self._reported_number = 0

    # -- the record of an earlier program -----------------------------------------------------

    def load(self, arm: str, calibration: str, motors: int) -> Record | None:
        """Return the record of an earlier program; raises `StateFileError` if it is unusable."""
        record = self._store.load()
        if record is not None:
            record.require_owner(arm, calibration, motors)
            self._writer.found(record)
        return record

    def taken_up(self) -> None:
        """Start writing: the record now belongs to this program."""
        self._taken_up = True

    # -- the motion mark ----------------------------------------------------------------------

    def begin_mark(self) -> None:
        """Request the motion mark, unless it is already on the disk."""
        self._moving = True
        if not self._mark_is_kept:
            self._ask()

    def mark_stands(self) -> bool:
        """Return whether the motion mark is on the disk, safe against a power cut.

        Raises `StateFileError` if the mark could not be written. Nothing may move then, because a
        program that dies during the motion would leave a wrong position behind.
        """
        if self._mark_is_kept:
            return True
        outcome = self._writer.outcome
        if outcome.number < self._asked_number:
            return False
        self._moving = False
        raise StateFileError(self._words(outcome.error))

    def mark_still(self) -> None:
        """Request a record of the arm at rest, without the motion mark."""
        self._moving = False
        self._ask()

    def due_s(self, still_since_s: float) -> float:
        """Return when to call `mark_still` if the arm stays at rest; infinity if not at all."""
        return still_since_s + STILL_S if self.owing else math.inf

    @property
    def owing(self) -> bool:
        """Whether the motion mark may still be on the disk, or the latest write has failed."""
        kept = self._writer.outcome.kept
        return self._moving or self._failed or (kept is not None and kept.in_motion)

    @property
    def _mark_is_kept(self) -> bool:
        """Whether a motion mark is on the disk and no later request removes it."""
        outcome = self._writer.outcome
        marked = outcome.kept is not None and outcome.kept.in_motion
        return marked and outcome.kept_number > self._cleared_number

    # -- the record in general ----------------------------------------------------------------

    def remember(self) -> None:
        """Request a write of the present record; a motion mark stays."""
        self._ask()

    @property
    def settled(self) -> bool:
        """Whether every requested write has ended, successfully or not."""
        return self._writer.outcome.number >= self._asked_number

    def trouble(self) -> str:
        """Return why the latest write failed, once for each failure; otherwise an empty string."""
        outcome = self._writer.outcome
        if outcome.number == self._reported_number:
            return ""
        self._reported_number = outcome.number
        return self._words(outcome.error) if outcome.error else ""

    def finish(self, timeout_s: float) -> None:
        """Wait for pending writes. Nothing is written after this, not even by a slow disk."""
        self._writer.finish(timeout_s)

    def _ask(self) -> None:
        """Request a write of the present record, unless it is the same as the previous one."""
        record = self._describe(self._moving)
        nothing_known = record.trust == Trust.UNKNOWN.value and not self._moving
        if not self._taken_up or (record == self._asked and not self._failed):
            return
        if nothing_known and self._asked is None:
            return  # an unusable record is left as it is until the arm has moved
        self._asked = record
        self._asked_number = self._writer.put(record)
        if not record.in_motion:
            # From now on an earlier mark counts as gone: a slow disk may clear it at any moment.
            self._cleared_number = self._asked_number

    @property
    def _failed(self) -> bool:
        outcome = self._writer.outcome
        return bool(outcome.error) and outcome.number >= self._asked_number

    def _words(self, error: str) -> str:
        return (
            f"the position of {self._describe(self._moving).arm} cannot be saved ({error}): "
            "free some disk space or make the folder writable"
        )
