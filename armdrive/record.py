"""What is remembered of an arm between programs: one small JSON file per arm, replaced whole.

The file is marked before the arm leaves stand-still and cleared when it has been still again, so
that a program that dies in mid-motion leaves a mark instead of a wrong position.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from armdrive.durable import DISK, Files, always, put_aside, remove_durably, replace_durably
from armdrive.errors import StateFileError
from armdrive.record_text import LONGEST, Record, from_text, to_text

__all__ = ["FileRecorder", "NoRecorder", "Record", "Recorder"]

BAD = ".bad"
"""The ending of a file that could not be used, kept aside when a new one took its place."""


class Recorder(Protocol):
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

    def __init__(self, path: Path, files: Files = DISK) -> None:
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
