"""Small files that outlive a power cut: the few operations of a file system, and their order.

A file is replaced, never rewritten: written beside, brought to the disk, renamed over the old one,
and the folder brought to the disk as well. Whoever reads finds the old file or the new one.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path

BESIDE = ".new"
"""The ending of a file that is being written; one that was left behind is overwritten."""

PRIVATE = 0o600
_CHUNK = 1_000_000  # a read allocates what it asks for, whatever the file has
_NO_SUCH_SYNC = frozenset({errno.EINVAL, errno.ENOTSUP, errno.EBADF})
"""What a file system says that cannot bring a folder to the disk by itself."""


class Files:
    """The operations on a disk. Each raises `OSError`, and each is a moment for a power cut."""

    def read(self, path: Path, most: int) -> bytes:
        """Return the first `most` bytes of a plain file; whatever else is there is an `OSError`.

        A device is not even opened: opening a serial port resets the board behind it.
        """
        _require_plain(path.stat(), path)
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        try:
            _require_plain(os.fstat(handle), path)
            return _read(handle, most)
        finally:
            os.close(handle)

    def create(self, path: Path) -> int:
        """Open an empty file, for this user alone; return its handle."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
        return os.open(path, flags, PRIVATE)

    def write(self, handle: int, data: bytes) -> int:
        """Write some of the data, and return how much of it."""
        return os.write(handle, data)

    def sync(self, handle: int) -> None:
        """Bring a file to the disk, through the drive's own memory where the system can."""
        with contextlib.suppress(ImportError, AttributeError, OSError):
            import fcntl

            fcntl.fcntl(handle, fcntl.F_FULLFSYNC)  # type: ignore[attr-defined,unused-ignore]
            return
        os.fsync(handle)

    def close(self, handle: int) -> None:
        """Close a file."""
        os.close(handle)

    def replace(self, source: Path, target: Path) -> None:
        """Rename a file over another."""
        source.replace(target)

    def remove(self, path: Path) -> None:
        """Remove a file; none there is no error."""
        path.unlink(missing_ok=True)

    def sync_folder(self, folder: Path) -> None:
        """Bring a folder's names to the disk, where the system can."""
        if os.name != "posix":
            return
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        except OSError as error:
            if error.errno not in _NO_SUCH_SYNC:
                raise
        finally:
            os.close(handle)

    def make_folder(self, folder: Path) -> None:
        """Make a folder and those above it."""
        folder.mkdir(parents=True, exist_ok=True)

    def may_change(self, folder: Path) -> bool:
        """Tell whether files of this folder can be replaced; one that is not there yet can be."""
        return not folder.exists() or os.access(folder, os.W_OK | os.X_OK)


DISK = Files()


class NotWanted(OSError):
    """The file was not put in place, since nobody wants it any more."""


def always() -> bool:
    """Want it, whatever happens meanwhile."""
    return True


def replace_durably(
    files: Files,
    path: Path,
    data: bytes,
    *,
    aside: Path | None = None,
    writer: str = "",
    wanted: Callable[[], bool] = always,
) -> None:
    """Replace a file; when this returns, the new one outlives a power cut. Raises `OSError`.

    With `aside` the old file is kept under that name. Whatever fails leaves the old file, but the
    very last step, after which nobody knows which of the two a power cut would leave. Where more
    than one program may do this at a time, each gives itself another name as `writer`. A disk may
    take its time: `wanted()` is asked once more before the new file takes its place.
    """
    files.make_folder(path.parent)
    beside = path.with_name(path.name + writer + BESIDE)
    try:
        _write_whole(files, beside, data)
        _require(wanted, path)
        if aside is not None:
            put_aside(files, path, aside)
        files.replace(beside, path)
    except BaseException:
        with contextlib.suppress(OSError):
            files.remove(beside)
        raise
    files.sync_folder(path.parent)


def stamp_of(path: Path) -> tuple[int, int] | None:
    """Return what changes when a file does: its time in ns, and its size; None of no file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def put_aside(files: Files, path: Path, aside: Path) -> None:
    """Rename a file, if it is there."""
    with contextlib.suppress(FileNotFoundError):
        files.replace(path, aside)


def remove_durably(files: Files, path: Path) -> None:
    """Remove a file; when this returns, a power cut does not bring it back."""
    files.remove(path)
    files.sync_folder(path.parent)


def _require(wanted: Callable[[], bool], path: Path) -> None:
    if not wanted():
        raise NotWanted(errno.ECANCELED, "nobody wants it any more", str(path))


def _write_whole(files: Files, path: Path, data: bytes) -> None:
    handle = files.create(path)
    try:
        left = memoryview(data)
        while left:
            left = left[files.write(handle, bytes(left)) :]
        files.sync(handle)
    finally:
        files.close(handle)


def _require_plain(found: os.stat_result, path: Path) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is no plain file", str(path))


def _read(handle: int, most: int) -> bytes:
    data = bytearray()
    while len(data) < most and (more := os.read(handle, min(most - len(data), _CHUNK))):
        data += more
    return bytes(data)
