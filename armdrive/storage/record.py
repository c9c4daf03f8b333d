"""What is remembered of an arm between programs: one small JSON file per arm, replaced whole.

The file is marked before the arm leaves stand-still and cleared when it has been still again, so
that a program that dies in mid-motion leaves a mark instead of a wrong position.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

from armdrive.errors import StateFileError
from armdrive.status import Trust
from armdrive.storage.files import (
    DISK,
    StateFiles,
    always,
    put_aside,
    remove_durably,
    replace_durably,
)
from kinematics.errors import finite
from kinematics.spaces import Motors

# What a record holds, and its text: JSON with a checksum, read back strictly.
#
# Whatever is not exactly what was written is a `StateFileError` that says what is wrong with it.

FORMAT = 2
"""1 had no checksum."""

LONGEST = 16384
"""Bytes. No record is a tenth as long; what is longer is not even read."""

MOST_MOTORS = 64
STEPS_MOST = 10_000_000_000
"""No motor has ever stood further from its zero; arithmetic with it stays exact."""

COORDINATE_MOST = 1e6
RESTORING = frozenset({Trust.REFERENCED.value, Trust.RESTORED.value})
"""The next program takes up a position that was recorded with one of these."""

_CHECK = "check"
_OPTIONAL = ("taken", "unsure")


@dataclass(frozen=True, slots=True)
class Record:
    """The last known position of one arm: registers plus reference offset, and how trusted.

    Of an arm with backlash, `taken` says where each motor is within it, but assumes that of the
    motors `unsure`, counted from 0. Of others both are empty, and not written.
    """

    arm: str
    calibration: str
    offset: tuple[int, ...]
    registers: tuple[int, ...]
    coordinates: tuple[float, ...]
    trust: str
    reason: str
    in_motion: bool = False
    taken: tuple[int, ...] = ()
    unsure: tuple[int, ...] = ()

    @property
    def would_restore(self) -> bool:
        """Whether the next program would take this for the position if the registers agree."""
        return not self.in_motion and self.trust in RESTORING

    def require_owner(self, arm: str, calibration: str, motors: int) -> None:
        """Raise `StateFileError` unless this was recorded of such an arm."""
        if self.arm != arm:
            raise StateFileError(f"it is of the arm {self.arm}")
        if self.calibration != calibration:
            raise StateFileError("it was made with another calibration")
        if len(self.offset) != motors:
            raise StateFileError("it is of an arm with other motors")


def to_text(record: Record) -> bytes:
    """Return the text of a record."""
    entries = {"format": FORMAT, **asdict(record)}
    for name in _OPTIONAL:
        if not entries[name]:
            del entries[name]
    return json.dumps({**entries, _CHECK: _check(entries)}, indent=1).encode() + b"\n"


def from_text(text: bytes) -> Record:
    """Return the record of a text; raises `StateFileError` with the reason, and nothing else."""
    if len(text) > LONGEST:
        raise StateFileError(f"it is damaged: no record is longer than {LONGEST} bytes")
    if not text.strip(b" \r\n\t\x00"):
        raise StateFileError("it is empty")
    try:
        return _checked(_of_our_format(json.loads(text.decode("utf-8"))))
    except (ValueError, TypeError, RecursionError) as error:
        raise StateFileError(f"it is damaged: {error}") from None
    except KeyError as error:
        raise StateFileError(f"it is damaged: the entry {error} is missing") from None


def _of_our_format(entries: Any) -> dict[str, Any]:
    if not isinstance(entries, dict):
        raise TypeError("it is no table")
    number = entries.pop("format", None)
    if type(number) is not int:
        raise TypeError("it does not say its format")
    if number > FORMAT:
        raise StateFileError(f"a newer armdrive wrote it (format {number!s:.9}, not {FORMAT})")
    if number < FORMAT:
        raise StateFileError(f"an older armdrive wrote it (format {number!s:.9}, not {FORMAT})")
    return entries


def _checked(entries: dict[str, Any]) -> Record:
    if entries.pop(_CHECK) != _check({"format": FORMAT, **entries}):
        raise ValueError("its checksum is another one")
    record = Record(
        arm=_text(entries.pop("arm")),
        calibration=_text(entries.pop("calibration")),
        offset=_steps(entries.pop("offset")),
        registers=_steps(entries.pop("registers")),
        coordinates=tuple(map(_coordinate, _items(entries.pop("coordinates")))),
        trust=Trust(entries.pop("trust")).value,
        reason=_text(entries.pop("reason")),
        in_motion=_flag(entries.pop("in_motion")),
        **{name: _steps(entries.pop(name)) for name in _OPTIONAL if name in entries},
    )
    if entries:
        raise ValueError(f"nobody knows its entry {min(entries)!r:.40}")
    if len(record.offset) != len(record.registers):
        raise ValueError("it has more registers than offsets, or fewer")
    if not set(record.unsure) <= set(range(len(record.taken))):
        raise ValueError("it doubts motors that it says nothing of")
    return record


def _check(entries: Mapping[str, Any]) -> str:
    """Return a checksum of what the entries say, however they are laid out."""
    plain = json.dumps(entries, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(plain.encode()).hexdigest()


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.40} stands where text belongs")
    value.encode("utf-8")  # half a character is no text
    return value


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{value!r:.40} stands where true or false belongs")
    return value


def _items(value: object) -> list[object]:
    if not isinstance(value, list) or not 1 <= len(value) <= MOST_MOTORS:
        raise TypeError(f"{value!r:.40} stands where a list of numbers belongs")
    return value


def _steps(value: object) -> tuple[int, ...]:
    steps = Motors(_items(value))  # type: ignore[arg-type]
    if steps.largest > STEPS_MOST:
        raise ValueError("no motor has ever made so many steps")
    return steps


def _coordinate(value: object) -> float:
    number = finite("a coordinate", value)
    if abs(number) > COORDINATE_MOST:
        raise ValueError(f"{number:g} is no coordinate of an arm")
    return number


__all__ = ["FileRecorder", "NoRecorder", "PositionRecorder", "Record"]

BAD = ".bad"
"""The ending of a file that could not be used, kept aside when a new one took its place."""


class PositionRecorder(Protocol):
    """Somewhere that keeps a record. What cannot be done on the disk is an `OSError`."""

    def load(self) -> Record | None:
        """Return the record, None where there is none; raises `StateFileError`."""

    def refuse(self) -> None:
        """Hear that what was found cannot be used: it is kept aside when it is replaced."""

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Keep a record in place of the last one; it outlives a power cut from then on.

        `wanted()` is asked again when a slow disk is ready to put it in place.
        """

    def remove(self) -> None:
        """Keep nothing: what was kept is no longer true, and cannot be replaced."""


class NoRecorder:
    """Keeps nothing: simulated arms of a script begin anew each time."""

    def load(self) -> Record | None:
        """Return None."""
        return None

    def refuse(self) -> None:
        """Nothing was found."""

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Forget the record."""

    def remove(self) -> None:
        """Nothing is kept."""


class FileRecorder:
    """Keeps the record in a file, which is always whole: it is replaced, never rewritten."""

    def __init__(self, path: Path, files: StateFiles = DISK) -> None:
        self.path = path
        self._files = files
        self._refused = False
        self._tidied = False

    @property
    def aside(self) -> Path:
        """Where the last file is kept that could not be used; there is one at most."""
        return self.path.with_name(self.path.name + BAD)

    def load(self) -> Record | None:
        """Read the file. One that cannot be kept up to date is not believed either."""
        try:
            text = self._files.read_own(self.path, LONGEST + 1)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise StateFileError(
                f"the state file {self.path} cannot be read: {error.strerror or error}"
            ) from None
        try:
            record = from_text(text)
        except StateFileError as error:
            raise StateFileError(f"the state file {self.path} cannot be used: {error}") from None
        if not self._files.may_change(self.path.parent):
            raise StateFileError(
                f"the state file {self.path} may be out of date, since nothing can be written into "
                "its folder: make the folder writable"
            )
        return record

    def refuse(self) -> None:
        """Keep the present file aside when it is replaced."""
        self._refused = True

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Replace the file; the first time, also remove what killed programs left unfinished."""
        aside = self.aside if self._refused else None
        replace_durably(self._files, self.path, to_text(record), aside=aside, wanted=wanted)
        self._refused = False
        if not self._tidied:
            self._tidied = True
            for left in self._files.leftovers(self.path):
                with contextlib.suppress(OSError):
                    self._files.remove(left)

    def remove(self) -> None:
        """Remove the file, which takes no room on a full disk."""
        if self._refused:
            put_aside(self._files, self.path, self.aside)
        remove_durably(self._files, self.path)
        self._refused = False
