"""Write records to the disk: at once on simulated time, otherwise in a thread of its own.

Records are numbered in the order of `put`. If several are waiting, only the newest is written, so
that a slow disk never builds up a queue. The `WriteOutcome` reports the latest attempt.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from armdrive.storage.record import RESTORING, PositionRecorder, Record


@dataclass(frozen=True, slots=True)
class WriteOutcome:
    """The result of the latest attempt to write; `error` says why it failed.

    `kept` is the newest record known to be on the disk, and `kept_number` its number.
    """

    number: int = 0
    error: str = ""
    kept: Record | None = None
    kept_number: int = 0


class RecordWriter:
    """Writes records to the disk, and removes an old record that would mislead the next program.

    Without `wake`, `put` writes at once: simulated time stands still meanwhile, and runs repeat.
    With `wake`, a thread writes and calls `wake` after each record. The thread exists only while
    records are waiting. It is not a daemon, so that the last record is written even if a program
    ends without closing its arm.
    """

    def __init__(self, recorder: PositionRecorder, wake: Callable[[], None] | None = None) -> None:
        self.outcome = WriteOutcome()
        self._recorder = recorder
        self._wake = wake
        # The records that may be on the disk; an unusable one is only noted by `_refused`.
        self._left: set[Record] = set()
        self._refused = False
        self._ended = False
        self._number = 0
        self._turn = threading.Condition()
        self._waiting: Record | None = None
        self._at_work = False

    # -- what an earlier program has left -----------------------------------------------------

    def found(self, record: Record) -> None:
        """Note the record that is on the disk."""
        self._left = {record}

    def refused(self) -> None:
        """Note that the disk holds an unusable record, which the next program may misread."""
        self._refused = True
        self._recorder.refuse()

    # -- accepting records --------------------------------------------------------------------

    def put(self, record: Record) -> int:
        """Accept a record for writing; return its number."""
        with self._turn:
            self._number += 1
            if self._wake is None:
                self._write(record, self._number)
            else:
                self._waiting = record
                if not self._at_work:
                    self._at_work = True
                    self._start(self._wake)
            return self._number

    def finish(self, timeout_s: float) -> bool:
        """Wait until nothing is left to write, then write nothing more; return False on a timeout.

        A write that is still in progress on a slow disk takes no effect.
        """
        with self._turn:
            ended = self._turn.wait_for(lambda: not self._at_work, timeout_s)
        self._ended = True
        return ended

    def _start(self, wake: Callable[[], None]) -> None:
        try:
            name = "armdrive-record"
            threading.Thread(target=self._work, args=(wake,), name=name, daemon=False).start()
        except RuntimeError:  # out of threads, or the interpreter is shutting down
            self._work(wake)

    def _work(self, wake: Callable[[], None]) -> None:
        while (job := self._next()) is not None:
            self._write(*job)
            wake()

    def _next(self) -> tuple[Record, int] | None:
        with self._turn:
            record, self._waiting = self._waiting, None
            if record is None:
                self._at_work = False
                self._turn.notify_all()
                return None
            return record, self._number

    # -- writing ------------------------------------------------------------------------------

    def _write(self, record: Record, number: int) -> None:
        """Write a record to the disk, and report the outcome, which may be a failure."""
        if self._ended:
            return
        try:
            self._recorder.save(record, lambda: not self._ended)
        except Exception as error:  # any failure has to reach the wire's thread
            self.outcome = replace(self.outcome, number=number, error=self._failed(record, error))
        else:
            self._left, self._refused = {record}, False
            self.outcome = WriteOutcome(number, "", record, number)

    def _failed(self, record: Record, error: Exception) -> str:
        """Remove the old record from the disk if the next program would wrongly restore it."""
        words = str(error)
        if self._refused or any(_misleads(one, record) for one in self._left):
            try:
                self._recorder.remove()
            except OSError as another:
                words += f", and the old position is still there ({another})"
            else:
                self._left, self._refused = set(), False
        self._left.add(record)  # the new record may still be on the disk: only the last step failed
        return words


def _misleads(left: Record, now: Record) -> bool:
    """Return whether the next program would restore a position that this one no longer trusts."""
    if not left.would_restore:
        return False
    return now.trust not in RESTORING or now.offset != left.offset
