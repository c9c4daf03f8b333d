"""A disk that can be full, forget what was not brought to it, and be the last that is reached."""

from __future__ import annotations

import errno
import random
from pathlib import Path

from armdrive.storage.files import StateFiles, is_leftover

from .clock import CampaignPace


class Disk(StateFiles):
    """Names and their texts, as programs see them and as a power cut would leave them."""

    def __init__(self) -> None:
        self.texts: dict[Path, bytes] = {}
        self.full = False
        self.owner: CampaignPace | None = None
        self.ends_in: int | None = None
        """Operations until the program is killed; None for never."""
        self._handles: dict[int, Path] = {}
        self._last = 2
        self._safe: dict[Path, bytes] = {}
        self._unsynced: set[Path] = set()
        self._changes: list[tuple[Path, Path | None, bytes]] = []
        """Renamings and removals that the folder has not been synced behind: from, to, text."""

    def _pass(self) -> None:
        if self.owner is None:
            return
        if self.ends_in is not None:
            self.ends_in -= 1
            if self.ends_in < 0:
                self.owner.die()
        self.owner.live()

    def power_cut(self, draw: random.Random) -> None:
        """Forget what was not brought to the disk, or not all of it."""
        texts = dict(self._safe)
        for source, target, text in self._changes:
            if draw.random() < 0.5:
                continue  # it never got there
            texts.pop(source, None)
            if target is not None:
                whole = source not in self._unsynced
                texts[target] = text if whole else text[: draw.randrange(len(text) + 1)]
        self.texts, self._safe = texts, dict(texts)
        self._changes.clear()
        self._unsynced.clear()

    def read(self, path: Path, most: int) -> bytes:
        """Return the text."""
        if path not in self.texts:
            raise FileNotFoundError(path)
        return self.texts[path][:most]

    def read_own(self, path: Path, most: int, *, end: bool = False) -> bytes:
        """Return the text: there are no links here, and no other users."""
        return self.read(path, most)

    def leftovers(self, path: Path) -> list[Path]:
        """Return what killed programs did not finish."""
        return [each for each in self.texts if is_leftover(each, path)]

    def create(self, path: Path) -> int:
        """Create an empty file."""
        self._pass()
        if path in self.texts:
            raise FileExistsError(path)
        self._last += 1
        self.texts[path] = b""
        self._unsynced.add(path)
        self._handles[self._last] = path
        return self._last

    def write(self, handle: int, data: bytes) -> int:
        """Write half of it, or nothing where there is no room."""
        self._pass()
        if self.full:
            raise OSError(errno.ENOSPC, "No space left on device")
        half = data[: len(data) // 2 + 1]
        self.texts[self._handles[handle]] += half
        return len(half)

    def sync(self, handle: int) -> None:
        """Bring a file's text to the disk."""
        self._pass()
        self._unsynced.discard(self._handles[handle])

    def close(self, handle: int) -> None:
        """Close a file."""
        self._handles.pop(handle, None)

    def replace(self, source: Path, target: Path) -> None:
        """Rename."""
        self._pass()
        if source not in self.texts:
            raise FileNotFoundError(source)
        self.texts[target] = self.texts.pop(source)
        self._changes.append((source, target, self.texts[target]))

    def remove(self, path: Path) -> None:
        """Remove."""
        self._pass()
        if self.texts.pop(path, None) is not None:
            self._changes.append((path, None, b""))

    def sync_folder(self, folder: Path) -> None:
        """Bring the names to the disk."""
        self._pass()
        self._safe = dict(self.texts)
        self._changes.clear()

    def make_folder(self, folder: Path) -> None:
        """Do nothing."""
        self._pass()

    def may_change(self, folder: Path) -> bool:
        """Say yes."""
        return True
