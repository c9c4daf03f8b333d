"""The saved position of an arm: one small JSON file, always replaced as a whole.

The file is marked as in motion before the arm starts moving, and unmarked once the arm is at rest
again. A program that dies during a motion thus leaves a mark instead of a wrong position.
"""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from armdrive.errors import ArmFileError, StateFileError
from armdrive.errors.printable import reason_of
from armdrive.status import BELIEVED_WORDS, Trust
from armdrive.storage.files import (
    DISK,
    StateFiles,
    always,
    remove_durably,
    replace_durably,
)
from armdrive.text.reading import parse_json
from armdrive.text.toml import FORMAT_KEY, section_of, setting

# A record. Any deviation of its text is a `StateFileError` that says what is wrong.

FORMAT = 2  # format 1 had no checksum
LONGEST_RECORD = 16384  # bytes, ten times the longest record; a longer file is not parsed
MOST_MOTORS = 64  # far more than any arm has
STEPS_MOST = 10_000_000_000  # beyond any motor's travel; sums stay exact as floats
COORDINATE_MOST = 1e6  # in rad or mm: far beyond any joint and any gripper


@dataclass(frozen=True, slots=True)
class Record:
    """The last known position of one arm: motor registers, reference offset, and level of trust.

    For an arm with backlash, `taken` is each motor's position within its backlash, which is only
    assumed for the motors in `unsure` (counted from 0). Without backlash both are empty.
    """

    arm: str
    calibration: str
    offset: tuple[int, ...] = setting(low=-STEPS_MOST, high=STEPS_MOST)
    registers: tuple[int, ...] = setting(low=-STEPS_MOST, high=STEPS_MOST)
    coordinates: tuple[float, ...] = setting(low=-COORDINATE_MOST, high=COORDINATE_MOST)
    trust: str = setting(words=tuple(each.value for each in Trust))
    reason: str = setting()
    in_motion: bool = False
    taken: tuple[int, ...] = setting((), low=-STEPS_MOST, high=STEPS_MOST)
    unsure: tuple[int, ...] = ()

    def is_at(self, other: Record) -> bool:
        """Return whether both are of the same position, whatever their marks and their trust."""
        return self == replace(
            other, trust=self.trust, reason=self.reason, in_motion=self.in_motion
        )

    def require_owner(self, arm: str, calibration: str, motors: int) -> None:
        """Raise `StateFileError` unless the record is of this arm, with this calibration."""
        if self.arm != arm:
            raise StateFileError(f"it belongs to the arm {self.arm}")
        if self.calibration != calibration:
            raise StateFileError("it was made with another calibration")
        if len(self.offset) != motors:
            raise StateFileError("it belongs to an arm with a different number of motors")


def to_text(record: Record) -> bytes:
    """Return the text of a record."""
    return sealed(asdict(record), FORMAT)


def from_text(text: bytes) -> Record:
    """Parse a record; any error is a `StateFileError` with the reason."""
    try:
        record = section_of(Record, unsealed(text, FORMAT, LONGEST_RECORD), whole=False)
    except ArmFileError as error:
        raise _damaged(str(error)) from None
    if not 1 <= len(record.offset) == len(record.registers) <= MOST_MOTORS:
        raise _damaged("it has a different number of registers and offsets")
    if not set(record.unsure) <= set(range(len(record.taken))):
        raise _damaged("its entry 'unsure' names motors that 'taken' does not have")
    return record


# The text of a state file on which a motion depends: JSON with a format and a checksum.

_CHECK = "check"


def sealed(entries: Mapping[str, Any], number: int) -> bytes:
    """Return the text of entries in the format of this number."""
    formatted = {FORMAT_KEY: number, **entries}
    return json.dumps({**formatted, _CHECK: checksum(formatted)}).encode() + b"\n"


def unsealed(text: bytes, number: int, longest: int) -> dict[str, Any]:
    """Return the entries of a text, or raise a `StateFileError` that says what is wrong with it."""
    if len(text) > longest:
        raise _damaged(f"it is longer than {longest} bytes")
    if not text.strip(b" \r\n\t\x00"):
        raise StateFileError("it is empty")
    try:
        entries = parse_json(text.decode("utf-8"), _damaged)
    except ValueError as error:  # bytes that are no UTF-8
        raise _damaged(str(error)) from None
    if not isinstance(entries, dict):
        raise _damaged("it is not a JSON object")
    given = entries.get(FORMAT_KEY)
    if type(given) is not int:
        raise _damaged("it does not say its format")
    if given != number:  # asked first: another format may compute its checksum differently
        writer = "a newer" if given > number else "an older"
        raise StateFileError(f"{writer} armdrive wrote it (format {given!s:.9}, not {number})")
    if _CHECK not in entries:
        raise _damaged(f"the entry {_CHECK!r} is missing")
    if entries.pop(_CHECK) != checksum(entries):
        raise _damaged("its checksum does not match")
    del entries[FORMAT_KEY]
    return entries


def _damaged(why: str) -> StateFileError:
    return StateFileError(f"it is damaged: {why}")


def checksum(entries: Mapping[str, Any]) -> str:
    """Return a checksum of the entries, independent of their layout in the file."""
    plain = json.dumps(entries, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(plain.encode()).hexdigest()


class RecordStore(Protocol):
    """Stores one record. Raises `OSError` if the disk fails."""

    def load(self) -> Record | None:
        """Return the record, or None if there is none; raises `StateFileError`."""

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Replace the record; once this returns, the new one survives a power cut.

        As a disk may be slow, `wanted()` is called again just before the new record takes effect.
        """

    def remove(self) -> None:
        """Delete the record, which is no longer true and cannot be replaced."""


class RecordInMemory:
    """Keeps the record for other connections of this program: the disk is left alone."""

    def __init__(self) -> None:
        self._record: Record | None = None

    def load(self) -> Record | None:
        """Return the latest record."""
        return self._record

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Keep a record."""
        if wanted():
            self._record = record

    def remove(self) -> None:
        """Drop the record."""
        self._record = None


class RecordFile:
    """Stores the record in a file, which is always complete: it is replaced, never rewritten."""

    def __init__(self, path: Path, files: StateFiles = DISK) -> None:
        self.path = path
        self._files = files

    def load(self) -> Record | None:
        """Read the file. Reject a file that cannot be replaced, as it may be out of date."""
        try:
            text = self._files.read(self.path, LONGEST_RECORD + 1)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise StateFileError(
                f"the state file {self.path} cannot be read: {reason_of(error)}"
            ) from None
        try:
            record = from_text(text)
        except StateFileError as error:
            raise StateFileError(f"the state file {self.path} cannot be used: {error}") from None
        if not self._files.may_change(self.path.parent):
            raise StateFileError(
                f"the state file {self.path} may be out of date, because its folder is not "
                "writable: make the folder writable"
            )
        return record

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Replace the file."""
        replace_durably(self._files, self.path, to_text(record), wanted=wanted)

    def remove(self) -> None:
        """Remove the file, which works on a full disk too."""
        remove_durably(self._files, self.path)


# Writes records to the disk: at once on simulated time, otherwise in a thread of its own.
#
# Records are numbered in the order of `put`. If several are waiting, only the newest is written, so
# that a slow disk never builds up a queue. The `WriteOutcome` reports the latest attempt.


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
    """Writes records to the disk. Where one cannot be written, an old one that is wrong is removed.

    Without `wake`, `put` writes at once: simulated time stands still meanwhile, and runs repeat.
    With `wake`, a thread writes and calls `wake` after each record. The thread exists only while
    records are waiting. It is not a daemon, so that the last record is written even if a program
    ends without closing its arm.
    """

    def __init__(self, store: RecordStore, wake: Callable[[], None] | None = None) -> None:
        self.outcome = WriteOutcome()
        self._store = store
        self._wake = wake
        self._left: Record | None = None
        """The record on the disk; None if there may be none, or another."""
        self._ended = False
        self._number = 0
        self._turn = threading.Condition()
        self._waiting: Record | None = None
        self._at_work = False

    def found(self, record: Record) -> None:
        """Note the record of an earlier program, which is on the disk."""
        self._left = record

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
            self._store.save(record, lambda: not self._ended)
        except Exception as error:  # any failure has to reach the wire's thread
            # once ended, the next program may hold the arm, and the record may be its own
            words = "" if self._ended else self._failed(record, error)
            self.outcome = replace(self.outcome, number=number, error=words)
        else:
            self._left = record
            self.outcome = WriteOutcome(number, "", record, number)

    def _failed(self, record: Record, error: Exception) -> str:
        """Remove the old record unless it is still true; return what went wrong."""
        words = reason_of(error)
        believed = record.trust in BELIEVED_WORDS
        if believed and self._left is not None and record.is_at(self._left):
            return words
        self._left = None
        try:
            self._store.remove()
        except OSError as another:
            words += f", and the old position is still there ({reason_of(another)})"
        return words
