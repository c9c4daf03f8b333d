"""What is remembered of an arm between programs: one small JSON file per arm, replaced whole.

The file is marked before the arm leaves stand-still and cleared when it has been still again, so
that a program that dies in mid-motion leaves a mark instead of a wrong position.
"""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

from armdrive.errors import StateFileError
from armdrive.status import Trust
from kinematics.errors import BadNumber, finite
from kinematics.spaces import Motors

FORMAT = 1


@dataclass(frozen=True, slots=True)
class Record:
    """The last known position of one arm: registers plus reference offset, and how trusted."""

    arm: str
    calibration: str
    offset: tuple[int, ...]
    registers: tuple[int, ...]
    coordinates: tuple[float, ...]
    trust: str
    reason: str
    in_motion: bool = False


class Recorder(Protocol):
    """Somewhere that keeps a record."""

    def load(self) -> Record | None:
        """Return the record, None where there is none; raises `StateFileError`."""

    def save(self, record: Record) -> None:
        """Keep a record in place of the last one."""


class NoRecorder:
    """Keeps nothing: simulated arms of a script begin anew each time."""

    def load(self) -> Record | None:
        """Return None."""
        return None

    def save(self, record: Record) -> None:
        """Forget the record."""


class FileRecorder:
    """Keeps the record in a file, which is always whole: it is replaced, never rewritten."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def load(self) -> Record | None:
        """Read the file."""
        try:
            text = self.path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError) as error:
            raise StateFileError(f"the state file {self.path} cannot be read: {error}") from None
        try:
            return _checked(json.loads(text))
        except (ValueError, TypeError, KeyError) as error:
            raise StateFileError(f"the state file {self.path} is damaged: {error}") from None

    def save(self, record: Record) -> None:
        """Replace the file."""
        replace_file(self.path, json.dumps({"format": FORMAT, **asdict(record)}, indent=1))


def replace_file(path: Path, text: str) -> None:
    """Write a file so that a reader finds the old text or the new one, never half of one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with _temporary_beside(path) as (handle, name):
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text + "\n")
        Path(name).replace(path)


@contextlib.contextmanager
def _temporary_beside(path: Path) -> Iterator[tuple[int, str]]:
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        yield handle, name
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise


def _checked(entries: Any) -> Record:
    if not isinstance(entries, dict) or entries.pop("format", None) != FORMAT:
        raise ValueError("it is of another format")
    record = Record(
        arm=_text(entries["arm"]),
        calibration=_text(entries["calibration"]),
        offset=Motors(entries["offset"]),
        registers=Motors(entries["registers"]),
        coordinates=tuple(finite("a coordinate", value) for value in entries["coordinates"]),
        trust=Trust(entries["trust"]).value,
        reason=_text(entries["reason"]),
        in_motion=entries["in_motion"] is not False,
    )
    if len(record.offset) != len(record.registers) or not record.offset:
        raise BadNumber("the number of motors", len(record.offset))
    return record


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} stands where text belongs")
    return value
