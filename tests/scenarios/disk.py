"""A simulated disk that can be full, lose unsynced data, and kill the program at an operation."""

import errno
import random
from pathlib import Path

from armdrive.storage.files import StateFiles

from .program import ProgramTime


class Disk(StateFiles):
    """Files with their contents, as programs see them and as a power cut would leave them."""

    def __init__(self) -> None:
        self.texts: dict[Path, bytes] = {}
        self.full = False
        self.owner: ProgramTime | None = None
        self.kill_after: int | None = None
        """Operations until the program is killed; None for never."""
        self._handles: dict[int, Path] = {}
        self._last = 2
        self._safe: dict[Path, bytes] = {}
        self._unsynced: set[Path] = set()
        self._changes: list[tuple[Path, Path | None, bytes]] = []
        """Renames and removals since the folder was last synced: from, to, text."""

    def _count_operation(self) -> None:
        if self.owner is None:
            return
        if self.kill_after is not None:
            self.kill_after -= 1
            if self.kill_after < 0:
                self.owner.kill()
        self.owner.check_alive()

    def power_cut(self, draw: random.Random) -> None:
        """Lose some of the changes that were not synced, and parts of unsynced files."""
        texts = dict(self._safe)
        for source, target, text in self._changes:
            if draw.random() < 0.5:
                continue  # this change did not reach the disk
            texts.pop(source, None)
            if target is not None:
                whole = source not in self._unsynced
                texts[target] = text if whole else text[: draw.randrange(len(text) + 1)]
        self.texts, self._safe = texts, dict(texts)
        self._changes.clear()
        self._unsynced.clear()

    def read(self, path: Path, most: int) -> bytes:
        """Return a file's text."""
        if path not in self.texts:
            raise FileNotFoundError(path)
        return self.texts[path][:most]

    def create(self, path: Path) -> int:
        """Create an empty file."""
        self._count_operation()
        if path in self.texts:
            raise FileExistsError(path)
        self._last += 1
        self.texts[path] = b""
        self._unsynced.add(path)
        self._handles[self._last] = path
        return self._last

    def write(self, handle: int, data: bytes) -> int:
        """Write half of the data, or raise `OSError` if the disk is full."""
        self._count_operation()
        if self.full:
            raise OSError(errno.ENOSPC, "No space left on device")
        half = data[: len(data) // 2 + 1]
        self.texts[self._handles[handle]] += half
        return len(half)

    def sync(self, handle: int) -> None:
        """Sync a file's text."""
        self._count_operation()
        self._unsynced.discard(self._handles[handle])

    def close(self, handle: int) -> None:
        """Close a file."""
        self._handles.pop(handle, None)

    def replace(self, source: Path, target: Path) -> None:
        """Rename a file."""
        self._count_operation()
        if source not in self.texts:
            raise FileNotFoundError(source)
        self.texts[target] = self.texts.pop(source)
        self._changes.append((source, target, self.texts[target]))

    def remove(self, path: Path) -> None:
        """Remove a file."""
        self._count_operation()
        if self.texts.pop(path, None) is not None:
            self._changes.append((path, None, b""))

    def sync_folder(self, folder: Path) -> None:
        """Sync all names."""
        self._count_operation()
        self._safe = dict(self.texts)
        self._changes.clear()

    def make_folder(self, folder: Path) -> None:
        """Do nothing."""
        self._count_operation()

    def may_change(self, folder: Path) -> bool:
        """Return True: every folder may be changed."""
        return True
