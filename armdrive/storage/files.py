"""Write small files that survive a power cut and are safe in folders shared with other users.

A file is replaced, never rewritten: a new file with a random name is written in the same folder,
synced, and renamed over the old file; then the folder is synced. A reader finds either the old file
or the new one. All of armdrive writes its files through this module; text/reading.py opens the
files that are only read.

In a shared folder, other users can put links, pipes or files of their own in our places. So we
always create the files that we write (`O_EXCL`) and never write to one that we find. `read_own`,
`append_line` and `create_lock` follow no link and accept only plain files.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import socket
import stat
import struct
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from armdrive.errors import BadRequest
from armdrive.errors.printable import reason_of
from armdrive.text.reading import (
    CAREFULLY,
    PRIVATE,
    is_own,
    open_own,
    read_own,
    read_plain,
    require_plain,
)

if sys.platform == "darwin":
    import fcntl

UNFINISHED = ".new"  # ending of a file that is being written, after a random part
_RANDOM_BYTES = 8  # 16 hexadecimal digits, which no other user guesses
# What follows the target's name in the name of an unfinished file.
_UNFINISHED_ENDING = re.compile(r"(\.[0-9a-f]{16})?" + re.escape(UNFINISHED))

PRIVATE_FOLDER = 0o700  # for this user alone
# The errors of a file system that cannot sync a folder.
_CANNOT_SYNC_FOLDER = frozenset({errno.EINVAL, errno.ENOTSUP, errno.EBADF})


class StateFiles:
    """The operations on a disk. Each may raise `OSError`; tests cut the power between any two."""

    def read(self, path: Path, most: int) -> bytes:
        """Return the first `most` bytes of a plain file, following links.

        For files that a person edits (points, programs). Use `read_own` for armdrive's own files.
        """
        return read_plain(path, most)

    def read_own(self, path: Path, most: int, *, end: bool = False) -> bytes:
        """Return the first (with `end` the last) `most` bytes of a file owned by this user or root.

        Raises `OSError` for a link, a pipe, a device, a folder, and another user's file.
        """
        return read_own(path, most, end=end)

    def create(self, path: Path) -> int:
        """Create an empty private file; return its handle.

        Raises `FileExistsError` if the name is taken, even by a broken link.
        """
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | CAREFULLY, PRIVATE)
        _set_mode(handle)
        return handle

    def leftovers(self, path: Path) -> list[Path]:
        """Return the unfinished files of programs that were killed while replacing `path`."""
        with contextlib.suppress(OSError):
            return [each for each in path.parent.iterdir() if is_leftover(each, path)]
        return []

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
        """Make a private folder, and its parents.

        Raises `OSError` if the path contains a link that another user may have put there.
        """
        folder = folder.absolute()
        _require_followable(folder)
        missing = [each for each in (folder, *folder.parents) if not each.is_dir()]
        for each in reversed(missing):
            try:
                each.mkdir(PRIVATE_FOLDER)
            except FileExistsError:
                if not each.is_dir():  # a folder is fine: another program has just made it
                    raise NotADirectoryError(
                        errno.ENOTDIR, "a file is where the folder should be", str(each)
                    ) from None
            else:
                _widen(each)

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
    aside: Path | None = None,
    wanted: Callable[[], bool] = always,
) -> None:
    """Replace a file; once this returns, the new file survives a power cut. Raises `OSError`.

    A link at `path` is itself replaced; its target stays unchanged. With `aside`, the old file is
    kept under that name. Any failure leaves the old file in place. Only if the very last step
    fails, a power cut may leave either file. As a disk may be slow, `wanted()` is called just
    before the new file takes its place.
    """
    files.make_folder(path.parent)
    # In the same folder, because a file cannot be renamed from one file system to another.
    temporary = path.with_name(f"{path.name}.{os.urandom(_RANDOM_BYTES).hex()}{UNFINISHED}")
    with _naming(path):  # if this fails, a file of that name is not ours to remove
        handle = files.create(temporary)
    try:
        with _naming(path):
            _write_whole(files, handle, (data,) if isinstance(data, bytes) else data)
        _require(wanted, path)
        if aside is not None:
            put_aside(files, path, aside)
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
    """Raise `OSError` if no file can be made in a folder; leaves nothing behind.

    If the folder does not exist yet, the nearest parent that exists is tried.
    """
    present = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    trial = present / f"{os.urandom(_RANDOM_BYTES).hex()}{UNFINISHED}"
    try:
        os.close(DISK.create(trial))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(folder)) from None
    DISK.remove(trial)


def append_line(path: Path, line: str) -> None:
    """Append a line to one of this user's files; create the file if it does not exist.

    A last line that was only half written, as on a full disk, is ended first. Raises `OSError`,
    also for a link, for anything but a plain file, for another user's file, and for a file with a
    second name (a hard link), through which another user may have access.
    """
    DISK.make_folder(path.parent)
    handle = open_own(path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
    try:
        _require_one_name(os.fstat(handle), path)
        _set_mode(handle)
        with _naming(path):
            whole = not os.lseek(handle, 0, os.SEEK_END) or _byte_before(handle) == b"\n"
            left = memoryview((b"" if whole else b"\n") + line.encode() + b"\n")
            while left:
                left = left[os.write(handle, left) :]
    finally:
        os.close(handle)


def _byte_before(handle: int) -> bytes:
    """Return the byte before the place in a file that is read and written next."""
    os.lseek(handle, -1, os.SEEK_CUR)
    return os.read(handle, 1)


def create_lock(path: Path) -> None:
    """Create a plain file to take a lock on, unless there is one already.

    Raises `OSError` for anything else at `path`: a link, a pipe, a device, a folder, or a file with
    a second name (a hard link), because taking a lock may empty the file.
    """
    DISK.make_folder(path.parent)
    try:
        os.close(DISK.create(path))
    except FileExistsError:
        found = path.lstat()
        require_plain(found, path)
        _require_one_name(found, path)


def followed(path: Path) -> Path:
    """Return the real path of a person's file, which may be a link.

    Raises `OSError` for a link that another user may have put there.
    """
    _require_followable(path.absolute())
    return Path(os.path.realpath(path))


def is_leftover(each: Path, path: Path) -> bool:
    """Return whether `each` is an unfinished replacement of `path`."""
    rest = each.name.removeprefix(path.name)
    return rest != each.name and bool(_UNFINISHED_ENDING.fullmatch(rest))


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


def put_aside(files: StateFiles, path: Path, aside: Path) -> None:
    """Rename a file, if it exists."""
    with contextlib.suppress(FileNotFoundError):
        files.replace(path, aside)


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


def _require_one_name(found: os.stat_result, path: Path) -> None:
    if found.st_nlink > 1:
        raise OSError(errno.EMLINK, "it has a second name (a hard link)", str(path))


def _require_followable(path: Path) -> None:
    """Raise `OSError` for a link in the path that another user may have planted.

    In a world-writable folder, any user can plant a link that redirects our files. A link is
    trusted if it belongs to this user, to root, or to the owner of its folder.
    """
    for each in (path, *path.parents):
        try:
            found = each.lstat()
        except OSError:
            continue  # missing or unreadable: the next operation reports the error
        if not stat.S_ISLNK(found.st_mode) or is_own(found):
            continue
        if found.st_uid != each.parent.stat().st_uid:
            raise PermissionError(errno.EPERM, "it is reached by another user's link", str(each))


def _set_mode(handle: int) -> None:
    """Make a file private, whatever the umask."""
    if os.name == "posix":
        os.fchmod(handle, PRIVATE)


def _widen(folder: Path) -> None:
    """Restore the owner's rights on a new folder if a strict umask has removed them."""
    if os.name == "posix" and stat.S_IMODE(folder.lstat().st_mode) != PRIVATE_FOLDER:
        folder.chmod(PRIVATE_FOLDER)


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
    """Return the folder of saved positions, simulated worlds, locks and sockets."""
    return _folder("state")


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


# Checks that a folder is private, and that a caller on a local socket is the same user.

_CREDENTIALS = struct.Struct("3i")  # process, user, group: Linux's `struct ucred`


def is_private(folder: Path) -> bool:
    """Return whether only this user has access to a folder. POSIX only."""
    seen = folder.stat()
    return seen.st_uid == os.getuid() and not stat.S_IMODE(seen.st_mode) & 0o077


def is_ours(fileno: int) -> bool:
    """Return whether the peer on a local socket is this user, or root, who may do anything.

    Where the system does not reveal the peer's user, rely on the permissions of folder and socket.
    """
    user = peer_user(fileno)
    return user is None or user in (0, os.getuid())


def peer_user(fileno: int) -> int | None:
    """Return the user id of the peer; None where the system does not reveal it."""
    option = getattr(socket, "SO_PEERCRED", None)
    if option is None:
        return None
    with socket.socket(fileno=os.dup(fileno)) as end:
        data = end.getsockopt(socket.SOL_SOCKET, option, _CREDENTIALS.size)
    return int(_CREDENTIALS.unpack(data)[1])
