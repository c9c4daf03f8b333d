"""Write records to the disk: at once on simulated time, otherwise in a thread of its own.

Records are numbered in the order of `put`. If several are waiting, only the newest is written, so
that a slow disk never builds up a queue. The `WriteOutcome` reports the latest attempt.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

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


class Keeper:
    """Writes records to the disk, and removes an old record that would mislead the next program."""

    def __init__(self, recorder: PositionRecorder) -> None:
        self._recorder = recorder
        self._left: set[Record] = set()
        self._refused = False
        self._ended = False

    def found(self, record: Record) -> None:
        """Note the record that is on the disk."""
        self._left = {record}

    def refused(self) -> None:
        """Note that the disk holds an unusable record, which the next program may misread."""
        self._refused = True
        self._recorder.refuse()

    def end(self) -> None:
        """Write nothing from now on; a write still in progress on a slow disk takes no effect."""
        self._ended = True

    def keep(self, record: Record, number: int, before: WriteOutcome) -> WriteOutcome:
        """Write a record to the disk; return the result, which may be a failure."""
        if self._ended:
            return before
        try:
            self._recorder.save(record, lambda: not self._ended)
        except Exception as error:  # any failure has to reach the wire's thread
            return WriteOutcome(
                number, self._failed(record, error), before.kept, before.kept_number
            )
        self._left, self._refused = {record}, False
        return WriteOutcome(number, "", record, number)

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


class RecordWriter(Protocol):
    """Writes records to the disk in the order of `put`."""

    @property
    def outcome(self) -> WriteOutcome:
        """The result of the latest attempt to write."""

    def put(self, record: Record) -> int:
        """Accept a record for writing; return its number."""

    def finish(self, timeout_s: float) -> bool:
        """Wait until nothing is left to write; return False on a timeout."""


class AtOnce:
    """Writes on the caller's thread: simulated time stands still meanwhile, and runs repeat."""

    def __init__(self, keeper: Keeper) -> None:
        self._keeper = keeper
        self.outcome = WriteOutcome()
        self._number = 0

    def put(self, record: Record) -> int:
        """Write a record."""
        self._number += 1
        self.outcome = self._keeper.keep(record, self._number, self.outcome)
        return self._number

    def finish(self, timeout_s: float) -> bool:  # noqa: ARG002
        """Return True: nothing is ever left to write."""
        return True


class BesideTheWire:
    """Writes in a thread that exists while records are waiting; calls `wake` after each write.

    The thread is not a daemon, so that the last record is written even if a program ends without
    closing its arm.
    """

    def __init__(self, keeper: Keeper, wake: Callable[[], None]) -> None:
        self._keeper = keeper
        self._wake = wake
        self.outcome = WriteOutcome()
        self._number = 0
        self._turn = threading.Condition()
        self._waiting: Record | None = None
        self._at_work = False

    def put(self, record: Record) -> int:
        """Pass a record to the thread, without waiting."""
        with self._turn:
            self._number += 1
            self._waiting = record
            if not self._at_work:
                self._at_work = True
                self._start()
            return self._number

    def finish(self, timeout_s: float) -> bool:
        """Wait for the thread to finish; return False on a timeout."""
        with self._turn:
            return self._turn.wait_for(lambda: not self._at_work, timeout_s)

    def _start(self) -> None:
        try:
            threading.Thread(target=self._work, name="armdrive-record", daemon=False).start()
        except RuntimeError:  # out of threads, or the interpreter is shutting down
            self._work()

    def _work(self) -> None:
        while (job := self._next()) is not None:
            self.outcome = self._keeper.keep(*job, self.outcome)
            self._wake()

    def _next(self) -> tuple[Record, int] | None:
        with self._turn:
            record, self._waiting = self._waiting, None
            if record is None:
                self._at_work = False
                self._turn.notify_all()
                return None
            return record, self._number
