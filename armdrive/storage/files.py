"""Write small files that survive a power cut, and say where armdrive keeps its files.

A file is replaced, never rewritten: a new file with a random name is written in the same folder,
synced, and renamed over the old file; then the folder is synced. A reader finds either the old file
or the new one. All of armdrive writes its files through this module; text/reading.py opens the
files that are only read.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from armdrive.errors import BadRequest, StateFileError
from armdrive.errors.printable import reason_of
from armdrive.text.reading import read_plain

if sys.platform == "darwin":
    import fcntl

UNFINISHED = ".new"  # ending of a file that is being written, after a random part

PRIVATE, PRIVATE_FOLDER = 0o600, 0o700  # for this user alone
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
# The errors of a file system that cannot sync a folder.
_CANNOT_SYNC_FOLDER = frozenset({errno.EINVAL, errno.ENOTSUP, errno.EBADF})


class StateFiles:
    """The operations on a disk. Each may raise `OSError`; tests cut the power between any two."""

    def read(self, path: Path, most: int) -> bytes:
        """Return the first `most` bytes of a regular file, which a link may lead to."""
        return read_plain(path, most)

    def create(self, path: Path) -> int:
        """Create an empty private file; return its handle. Raises `FileExistsError`."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        return os.open(path, flags, PRIVATE)

    def write(self, handle: int, data: bytes) -> int:
        """Write some of the data; return the number of bytes written."""
        return os.write(handle, data)

    def sync(self, handle: int) -> None:
        """Flush a file to the disk, on macOS past the disk's write cache too."""
        if sys.platform == "darwin":
            with contextlib.suppress(OSError):
                fcntl.fcntl(handle, fcntl.F_FULLFSYNC)
                return
        os.fsync(handle)

    def close(self, handle: int) -> None:
        """Close a file."""
        os.close(handle)

    def replace(self, source: Path, target: Path) -> None:
        """Rename a file over another."""
        source.replace(target)

    def remove(self, path: Path) -> None:
        """Remove a file, if it exists."""
        path.unlink(missing_ok=True)

    def sync_folder(self, folder: Path) -> None:
        """Flush a folder's entries to the disk, where the system can."""
        if os.name != "posix":
            return
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        except OSError as error:
            if error.errno not in _CANNOT_SYNC_FOLDER:
                raise
        finally:
            os.close(handle)

    def make_folder(self, folder: Path) -> None:
        """Make a private folder, and its parents."""
        missing = [each for each in (folder, *folder.parents) if not each.is_dir()]
        for each in reversed(missing):  # `parents=True` would leave these open to a group
            each.mkdir(PRIVATE_FOLDER, exist_ok=True)

    def may_change(self, folder: Path) -> bool:
        """Return whether files in this folder can be replaced; true for a folder yet to be made."""
        return not folder.exists() or os.access(folder, os.W_OK | os.X_OK)


DISK = StateFiles()


class NotWanted(OSError):
    """The new file was dropped, because `wanted()` became false while it was being written."""


def always() -> bool:
    """Return True: the new file is wanted in any case."""
    return True


def replace_durably(
    files: StateFiles,
    path: Path,
    data: bytes | Iterable[bytes],
    *,
    wanted: Callable[[], bool] = always,
) -> None:
    """Replace a file; once this returns, the new file survives a power cut. Raises `OSError`.

    A link at `path` is itself replaced; its target stays unchanged. Any failure leaves the old file
    in place. Only if the very last step fails, a power cut may leave either file. As a disk may be
    slow, `wanted()` is called just before the new file takes its place.
    """
    files.make_folder(path.parent)
    # in the same folder, because a file cannot be renamed from one file system to another
    temporary = path.with_name(f"{path.name}.{os.urandom(8).hex()}{UNFINISHED}")
    with _naming(path):  # if this fails, a file of that name is not ours to remove
        handle = files.create(temporary)
    try:
        with _naming(path):
            _write_whole(files, handle, (data,) if isinstance(data, bytes) else data)
        _require(wanted, path)
        files.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            files.remove(temporary)
        raise
    files.sync_folder(path.parent)


def replace_file(path: Path, text: str) -> None:
    """Replace a file's text so that a reader finds either the old text or the new one, complete."""
    replace_durably(DISK, path, text.encode() + b"\n")


def write_named(path: Path, data: bytes) -> None:
    """Write a file that a person has named. Raises `OSError`, and `BadRequest` without its folder.

    The caller has made sure with `require_free` that the name is free.
    """
    require_folder(path)
    replace_durably(DISK, path.absolute(), data)


def require_folder(path: Path) -> None:
    """Raise `BadRequest` unless the folder of a file that a person has named exists.

    If it were made, a misspelt folder would keep the file, and the person would not find it.
    """
    folder = path.absolute().parent
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:  # a name that is too long, or has a NUL in it
        raise BadRequest(f"{path} could not be written: {reason_of(error)}") from None
    if not folder.is_dir():
        raise BadRequest(f"{path} could not be written: there is no folder {folder}; make it first")


def require_free(path: Path, *, overwrite: bool, how: str = "add `overwrite=True`") -> None:
    """Raise `BadRequest` unless a file that a person has named may be written.

    Its folder must exist, and the file must not, except with `overwrite`; `how` says how to ask for
    that. Every command and call that writes such a file asks here first, before anything else is
    done.
    """
    require_folder(path)
    if path.is_dir():
        raise BadRequest(f"{path} could not be written: it is a folder")
    if path.exists() and not overwrite:
        raise BadRequest(f"{path} exists already: name another file, or {how}")


def require_writable(folder: Path) -> None:
    """Raise `OSError` if no file can be made in a folder, or in the nearest parent that exists."""
    present = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not DISK.may_change(present):
        raise PermissionError(errno.EACCES, "it is not writable", str(folder))


def stamp_of(path: Path) -> tuple[int, int] | None:
    """Return a file's modification time in ns and its size; None if there is no file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def kept_aside(path: Path) -> Path:
    """Return where the old text of a user's file is kept when a new one takes its place."""
    return path.with_name(f"{path.name}.before")


def remove_durably(files: StateFiles, path: Path) -> None:
    """Remove a file; once this returns, a power cut does not bring it back."""
    files.remove(path)
    files.sync_folder(path.parent)


def _require(wanted: Callable[[], bool], path: Path) -> None:
    if not wanted():
        raise NotWanted(errno.ECANCELED, "the new file is no longer wanted", str(path))


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Name a file in the errors of what is done to write it, such as those of a full disk."""
    try:
        yield
    except OSError as error:
        error.filename = str(path)
        raise


def _write_whole(files: StateFiles, handle: int, pieces: Iterable[bytes]) -> None:
    try:
        for piece in pieces:
            left = memoryview(piece)
            while left:
                left = left[files.write(handle, bytes(left)) :]
        files.sync(handle)
    finally:
        files.close(handle)


# Where arm files, points and saved states are stored on this computer.
#
# The environment variable `ARMDRIVE_HOME` moves all of them into one folder, for tests and for
# shared computers.


def arm_files() -> Path:
    """Return the folder of arm files."""
    return _folder("config") / "arms"


def points_file(arm: str) -> Path:
    """Return the file of an arm's named points, next to the folder of arm files."""
    return _folder("config") / "points" / f"{file_name(arm)}.toml"


def states() -> Path:
    """Return the folder of saved positions, simulated worlds, locks and sockets.

    Raises `StateFileError` if other users may change the folder. What is found there could be
    theirs: a position, a socket that receives our requests, or a link to another file of ours. So
    nothing is read from such a folder and nothing is written into it.
    """
    folder = _folder("state")
    with contextlib.suppress(OSError):  # missing or unreadable: the next operation says so
        found = folder.stat()
        if os.name == "posix" and not _is_private(found):
            raise StateFileError(
                f"other users can change the files in {folder}: give the folder to yourself alone "
                f"(`chmod 700 {folder}`), or set ARMDRIVE_HOME to another folder"
            )
    return folder


def _is_private(found: os.stat_result) -> bool:
    return found.st_uid == os.geteuid() and not found.st_mode & _OTHERS_WRITE


def recordings() -> Path:
    """Return the default folder for recordings."""
    return states() / "recordings"


# Characters of an arm's name in a file's name, of which most systems allow 255 bytes.
LONGEST_NAME = 100


def file_name(arm: str) -> str:
    """Return a unique file name for an arm's name, whatever characters the name contains.

    It has no capitals, because some file systems ignore case, and no dots, because they separate
    our endings, and is short enough for any of these.
    """
    plain = re.sub(r"[^a-z0-9_-]+", "_", arm.lower()).strip("_")[:LONGEST_NAME]
    if plain == arm:
        return plain
    # an argument that is not UTF-8 contains lone surrogates
    digest = hashlib.sha256(arm.encode("utf-8", "surrogatepass")).hexdigest()
    return f"{plain or 'arm'}-{digest[:8]}"


def _folder(kind: str) -> Path:
    home = os.environ.get("ARMDRIVE_HOME")
    if home:
        return Path(home) / kind
    import platformdirs

    if kind == "config":
        return platformdirs.user_config_path("armdrive", appauthor=False)
    return platformdirs.user_state_path("armdrive", appauthor=False)
