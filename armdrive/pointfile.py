"""The file of one arm's points on the disk: read anew for every question, changed in one piece."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.durable import DISK, Files, NotWanted, followed, replace_durably, stamp_of
from armdrive.errors import PointsChanged, PointsFileError
from armdrive.pointtext import parse_points
from armdrive.pointwriting import Writer, rounded

if TYPE_CHECKING:
    from armdrive.points import Taught

LARGEST_BYTES = 4_000_000
"""A file of points that is larger is none."""

TRIES = 5
"""So often a change is made anew when the file changes just while it is written."""

ASIDE = ".before"
"""The ending of the old file, where a new one could not keep its lines."""


class PointFile:
    """What stands in the file, and changes of it. Raises `PointsFileError`."""

    def __init__(
        self, path: Path, names: tuple[str, ...], writer: Writer, files: Files = DISK
    ) -> None:
        """Take the file of an arm whose joints are `names`; it need not be there yet."""
        self.path = path
        self._names = names
        self._writer = writer
        self._files = files

    @property
    def stamp(self) -> tuple[int, int] | None:
        """What changes when the file does, quick to ask for; None of no file."""
        return stamp_of(self.path)

    def read(self) -> Taught:
        """Return all that stands in the file now; nothing of no file."""
        return self._parsed(self._bytes())

    def change(self, change: Callable[[Taught], Taught]) -> None:
        """Make a change to what stands in the file, and to nothing that has come meanwhile."""
        for _ in range(TRIES):
            data = self._bytes()
            before = self._parsed(data)
            try:
                self._write(data, before, rounded(change(before)))
            except NotWanted:
                continue
            except OSError as error:
                why = error.strerror or error
                raise PointsFileError(f"{self.path} cannot be written: {why}") from None
            return
        raise PointsChanged(f"{self.path} is being written by another program: try again")

    def _write(self, data: bytes, before: Taught, after: Taught) -> None:
        text = self._writer.edited(data.decode("utf-8"), before, after)
        path = followed(self.path)
        aside = None
        if text is None:  # laid out in a way that is not ours: kept beside, and written anew
            text, aside = self._writer.document(after), path.with_name(path.name + ASIDE)
        replace_durably(
            self._files,
            path,
            text.encode("utf-8"),
            aside=aside,
            wanted=lambda: self._bytes() == data,
        )

    def _bytes(self) -> bytes:
        try:
            data = self._files.read(followed(self.path), LARGEST_BYTES + 1)
        except FileNotFoundError:
            return b""
        except OSError as error:
            why = error.strerror or error
            raise PointsFileError(f"{self.path} cannot be read: {why}") from None
        if len(data) > LARGEST_BYTES:  # half of it must never be taken for the whole, and kept
            raise PointsFileError(f"{self.path} is larger than {LARGEST_BYTES} bytes")
        return data

    def _parsed(self, data: bytes) -> Taught:
        try:
            return parse_points(data.decode("utf-8"), self._names)
        except (PointsFileError, UnicodeDecodeError) as error:
            raise PointsFileError(f"{self.path}: {error}") from None
