"""Small files that survive a power cut and other users: the operations on a disk, and their order.

A file is replaced, never rewritten: a new file with a random name is written in the same folder and
synced, renamed over the old one, and the folder is synced. A reader finds the old file or the new
one. Everything in armdrive that writes a file does it here; text/reading.py opens what is only
read.

A folder may be shared with other users, who can put links, pipes or files of their own where ours
belong. So a file that we write is created by us (`O_EXCL`), never opened because it was there;
`read_own`, `append` and `create_lock` follow no link and accept nothing but plain files.
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
from collections.abc import Callable, Iterable
from pathlib import Path

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

BESIDE = ".new"
"""The ending of a file that is being written, after a random part."""
_RANDOM_BYTES = 8
_LEFT_BEHIND = re.compile(r"(\.[0-9a-f]{16})?" + re.escape(BESIDE))
"""What follows the name in the name of a file that a killed program did not finish."""

PRIVATE_FOLDER = 0o700
_NO_SUCH_SYNC = frozenset({errno.EINVAL, errno.ENOTSUP, errno.EBADF})
"""The errors of a file system that cannot sync a folder by itself."""


class StateFiles:
    """The operations on a disk. Each raises `OSError`, and each is a moment for a power cut."""

    def read(self, path: Path, most: int) -> bytes:
        """Return the first `most` bytes of a plain file, which a link may lead to.

        For files that a person keeps (points, programs); what armdrive alone writes is `read_own`.
        """
        return read_plain(path, most)

    def read_own(self, path: Path, most: int, *, end: bool = False) -> bytes:
        """Return the first `most` bytes of a file that this user or root wrote; or its last.

        A link, a pipe, a device, a folder and another user's file are an `OSError`.
        """
        return read_own(path, most, end=end)

    def create(self, path: Path) -> int:
        """Create an empty file, for this user alone; return its handle.

        What is there already, even a link that leads nowhere, is a `FileExistsError`.
        """
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | CAREFULLY, PRIVATE)
        _set_mode(handle)
        return handle

    def leftovers(self, path: Path) -> list[Path]:
        """Return the unfinished files that killed programs left when they replaced `path`."""
        with contextlib.suppress(OSError):
            return [each for each in path.parent.iterdir() if is_leftover(each, path)]
        return []

    def write(self, handle: int, data: bytes) -> int:
        """Write some of the data, and return how much of it."""
        return os.write(handle, data)

    def sync(self, handle: int) -> None:
        """Bring a file to the disk, through the drive's own memory where the system can."""
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
        """Make a folder and those above it, for this user alone.

        Raises `OSError` where the way to it is a link that another user may have put there.
        """
        folder = folder.absolute()
        _require_followable(folder)
        missing = [each for each in (folder, *folder.parents) if not each.is_dir()]
        for each in reversed(missing):
            try:
                each.mkdir(PRIVATE_FOLDER)
            except FileExistsError:
                if not each.is_dir():  # another program may have made it just now
                    raise NotADirectoryError(
                        errno.ENOTDIR, "a file stands where the folder should be", str(each)
                    ) from None
            else:
                _widen(each)

    def may_change(self, folder: Path) -> bool:
        """Tell whether files of this folder can be replaced; one that is not there yet can be."""
        return not folder.exists() or os.access(folder, os.W_OK | os.X_OK)


DISK = StateFiles()


class NotWanted(OSError):
    """The file was not put in place, since nobody wants it any more."""


def always() -> bool:
    """Want it, whatever happens meanwhile."""
    return True


def replace_durably(
    files: StateFiles,
    path: Path,
    data: bytes | Iterable[bytes],
    *,
    aside: Path | None = None,
    wanted: Callable[[], bool] = always,
) -> None:
    """Replace a file; when this returns, the new one survives a power cut. Raises `OSError`.

    A link at `path` is replaced by the file; what it led to stays as it is. With `aside` the old
    file is kept under that name. Any failure leaves the old file, except a failure of the very last
    step: after that either file may be there after a power cut. A disk may take its time:
    `wanted()` is asked once more before the new file takes its place.
    """
    files.make_folder(path.parent)
    beside = path.with_name(f"{path.name}.{os.urandom(_RANDOM_BYTES).hex()}{BESIDE}")
    handle = files.create(beside)  # where this fails, nothing at `beside` is ours to remove
    try:
        _write_whole(files, handle, (data,) if isinstance(data, bytes) else data)
        _require(wanted, path)
        if aside is not None:
            put_aside(files, path, aside)
        files.replace(beside, path)
    except BaseException:
        with contextlib.suppress(OSError):
            files.remove(beside)
        raise
    files.sync_folder(path.parent)


def replace_file(path: Path, text: str) -> None:
    """Write a file's lines so that a reader finds the old text or the new one, never a part."""
    replace_durably(DISK, path, text.encode() + b"\n")


def append_line(path: Path, line: str) -> None:
    """Add a line to a file of this user's, and create the file where there is none.

    Raises `OSError`, also where the file is a link, no plain file, another user's, or has a second
    name (a hard link), under which somebody else may know it.
    """
    DISK.make_folder(path.parent)
    handle = open_own(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    try:
        _require_one_name(os.fstat(handle), path)
        _set_mode(handle)
        left = memoryview(line.encode() + b"\n")
        while left:
            left = left[os.write(handle, left) :]
    finally:
        os.close(handle)


def create_lock(path: Path) -> None:
    """Have a plain file at `path`, for a lock to be taken on; one that is there is left as it is.

    Raises `OSError` where something else is there: a link, a pipe, a device, a folder, or a file
    with a second name, which a lock that empties its file would empty.
    """
    DISK.make_folder(path.parent)
    try:
        os.close(DISK.create(path))
    except FileExistsError:
        found = path.lstat()
        require_plain(found, path)
        _require_one_name(found, path)


def followed(path: Path) -> Path:
    """Return where a person's file lies that may be kept elsewhere and linked to.

    Raises `OSError` for a link that another user may have put there.
    """
    _require_followable(path.absolute())
    return Path(os.path.realpath(path))


def is_leftover(each: Path, path: Path) -> bool:
    """Return whether `each` is an unfinished file with which `path` was to be replaced."""
    rest = each.name.removeprefix(path.name)
    return rest != each.name and bool(_LEFT_BEHIND.fullmatch(rest))


def stamp_of(path: Path) -> tuple[int, int] | None:
    """Return what changes when a file does: its time in ns, and its size; None of no file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def put_aside(files: StateFiles, path: Path, aside: Path) -> None:
    """Rename a file, if it is there."""
    with contextlib.suppress(FileNotFoundError):
        files.replace(path, aside)


def remove_durably(files: StateFiles, path: Path) -> None:
    """Remove a file; when this returns, a power cut does not bring it back."""
    files.remove(path)
    files.sync_folder(path.parent)


def _require(wanted: Callable[[], bool], path: Path) -> None:
    if not wanted():
        raise NotWanted(errno.ECANCELED, "nobody wants it any more", str(path))


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
    """Raise `OSError` where a link on the way is neither ours, root's, nor its folder's owner's.

    In a folder that everybody may write into, any user can put a link that leads our files away.
    """
    for each in (path, *path.parents):
        try:
            found = each.lstat()
        except OSError:
            continue  # not there yet, or out of sight: whatever is done next says so
        if not stat.S_ISLNK(found.st_mode) or is_own(found):
            continue
        if found.st_uid != each.parent.stat().st_uid:
            raise PermissionError(errno.EPERM, "it is reached by another user's link", str(each))


def _set_mode(handle: int) -> None:
    """Make a file this user's alone, whatever the umask is."""
    if os.name == "posix":
        os.fchmod(handle, PRIVATE)


def _widen(folder: Path) -> None:
    """Give a new folder the rights of its owner that a strict umask has taken."""
    if os.name == "posix" and stat.S_IMODE(folder.lstat().st_mode) != PRIVATE_FOLDER:
        folder.chmod(PRIVATE_FOLDER)


# Where arm files, points and remembered states live on this computer.
#
# `ARMDRIVE_HOME` in the environment moves both into one folder, for tests and for shared
# computers.


def arm_files() -> Path:
    """Return the folder of arm files."""
    return _folder("config") / "arms"


def key_file() -> Path:
    """Return the file in which a person gives the desk other keys."""
    return _folder("config") / "keys.toml"


def points_file(arm: str) -> Path:
    """Return the file of an arm's named points: beside the folder of arm files, one an arm."""
    return _folder("config") / "points" / f"{file_name(arm)}.toml"


def states() -> Path:
    """Return the folder of remembered positions, simulated worlds, locks and sockets."""
    return _folder("state")


def recordings() -> Path:
    """Return the folder into which recordings are written where no other is named."""
    return states() / "recordings"


def file_name(arm: str) -> str:
    """Return a file name for an arm, another one for every name, whatever characters it has.

    Without capitals and dots: some disks tell no capitals apart, and endings are ours to give.
    """
    plain = re.sub(r"[^a-z0-9_-]+", "_", arm.lower()).strip("_")
    if plain == arm:
        return plain
    # a word of the command line has lone surrogates where its bytes are no UTF-8
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


# What is this user's alone: a folder that nobody else gets into, a caller who is nobody else.

_CREDENTIALS = struct.Struct("3i")
"""Process, user, group: Linux's `struct ucred`."""


def is_private(folder: Path) -> bool:
    """Tell whether nobody but this user gets at what lies in a folder. POSIX alone."""
    seen = folder.stat()
    return seen.st_uid == os.getuid() and not stat.S_IMODE(seen.st_mode) & 0o077


def is_ours(fileno: int) -> bool:
    """Tell whether who calls over a local socket is this user, or root, who may do anything.

    Where the system does not tell, the folder and the mode of the socket have to do.
    """
    user = peer_user(fileno)
    return user is None or user in (0, os.getuid())


def peer_user(fileno: int) -> int | None:
    """Return the number of the user at the other end; None where the system does not tell."""
    option = getattr(socket, "SO_PEERCRED", None)
    if option is None:
        return None
    with socket.socket(fileno=os.dup(fileno)) as end:
        data = end.getsockopt(socket.SOL_SOCKET, option, _CREDENTIALS.size)
    return int(_CREDENTIALS.unpack(data)[1])
