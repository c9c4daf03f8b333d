"""Who brings records to the disk: at once on simulated time, else a thread beside the wire's.

Records are numbered as they are handed over. Of several that wait only the newest is written, so
that a slow disk never has a queue; what became of the newest that was tried is the `WriteOutcome`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from armdrive.storage.record import RESTORING, PositionRecorder, Record


@dataclass(frozen=True, slots=True)
class WriteOutcome:
    """What became of the newest record that was tried; `error` says why it could not be kept.

    `kept` is the newest record that surely is on the disk, and `kept_number` its number.
    """

    number: int = 0
    error: str = ""
    kept: Record | None = None
    kept_number: int = 0


class Keeper:
    """Brings one record after the other to the disk, and takes away what would mislead."""

    def __init__(self, recorder: PositionRecorder) -> None:
        self._recorder = recorder
        self._left: set[Record] = set()
        self._refused = False
        self._ended = False

    def found(self, record: Record) -> None:
        """Hear what the disk holds."""
        self._left = {record}

    def refused(self) -> None:
        """Hear that the disk holds something of which nobody knows what it will be taken for."""
        self._refused = True
        self._recorder.refuse()

    def end(self) -> None:
        """Write nothing from now on; what a slow disk is still busy with is not put in place."""
        self._ended = True

    def keep(self, record: Record, number: int, before: WriteOutcome) -> WriteOutcome:
        """Bring a record to the disk, or say why that failed."""
        if self._ended:
            return before
        try:
            self._recorder.save(record, lambda: not self._ended)
        except Exception as error:  # whatever it is, the wire's thread has to hear of it
            return WriteOutcome(
                number, self._failed(record, error), before.kept, before.kept_number
            )
        self._left, self._refused = {record}, False
        return WriteOutcome(number, "", record, number)

    def _failed(self, record: Record, error: Exception) -> str:
        """Take away what is still there if it would now be believed wrongly."""
        words = str(error)
        if self._refused or any(_misleads(one, record) for one in self._left):
            try:
                self._recorder.remove()
            except OSError as another:
                words += f", and the old position is still there ({another})"
            else:
                self._left, self._refused = set(), False
        self._left.add(record)  # the last step may have failed alone
        return words


def _misleads(left: Record, now: Record) -> bool:
    """Tell whether the next program would believe what this one does not believe any more."""
    if not left.would_restore:
        return False
    return now.trust not in RESTORING or now.offset != left.offset


class RecordWriter(Protocol):
    """Takes records to the disk, in the order in which they are handed over."""

    @property
    def outcome(self) -> WriteOutcome:
        """What became of the newest record that was tried."""

    def put(self, record: Record) -> int:
        """Hand a record over; return its number."""

    def finish(self, timeout_s: float) -> bool:
        """Wait until nothing is left to write; False when the time is over first."""


class AtOnce:
    """Writes on the caller's thread: on simulated time nothing takes time, and all is the same."""

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
        """Nothing is ever left."""
        return True


class BesideTheWire:
    """Writes in a thread that lives while something is to be written; `wake` is called after each.

    The thread is no daemon: a program that ends without closing its arm still has its last word
    written.
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
        """Hand a record over to the thread; takes no time."""
        with self._turn:
            self._number += 1
            self._waiting = record
            if not self._at_work:
                self._at_work = True
                self._start()
            return self._number

    def finish(self, timeout_s: float) -> bool:
        """Wait for the thread; afterwards it writes nothing more, if it was in time or not."""
        with self._turn:
            return self._turn.wait_for(lambda: not self._at_work, timeout_s)

    def _start(self) -> None:
        try:
            threading.Thread(target=self._work, name="armdrive-record", daemon=False).start()
        except RuntimeError:  # no thread is to be had, or the interpreter is about to end
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
