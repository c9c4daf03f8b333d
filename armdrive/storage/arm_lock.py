"""One program holds an arm at a time; beside its lock stands a local socket for the same user.

The lock goes by the port and the arm's name. How callers are served stands in control_server.py;
who answers them is passed in. Messages are JSON objects; nothing is ever unpickled. The socket lies
in a folder of this user's alone, and callers who are another user are hung up on, where the system
tells.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import stat
import sys
import tempfile
from multiprocessing.connection import Listener
from pathlib import Path

from armdrive.errors import ArmInUse, StateFileError
from armdrive.storage import files as places
from armdrive.storage.control_server import Answerer, ControlServer
from armdrive.storage.files import is_private, release_lock, replace_file, take_lock
from armdrive.storage.lock_client import address_of, holder_words, knock, notice_path
from armdrive.text.reading import PRIVATE

MOST_WAITING = 16
"""Callers that the system lets wait until they are accepted, which takes no time."""

LONGEST_ADDRESS = 100
"""Bytes; the path of a local socket may have 103 on some systems, and 107 on others."""


class ArmLock:
    """The right to drive one arm, for as long as this program wants it."""

    def __init__(self, names: list[str]) -> None:
        self._names = names
        self._locks: list[int] = []
        self._listener: Listener | None = None
        self._server: ControlServer | None = None
        self._folder: str | None = None

    def take(self) -> None:
        """Take every lock or raise `ArmInUse` that names the holder."""
        try:
            self._take_all()
        except OSError as error:
            self.release()
            raise StateFileError(
                f"nobody can hold an arm while {places.states()} cannot be written "
                f"({error.strerror or error}): make it writable, or set ARMDRIVE_HOME to a folder "
                "that is"
            ) from None

    def _take_all(self) -> None:
        for name in self._names:
            lock = take_lock(notice_path(name, "lock"))
            if lock is None:
                self.release()
                raise ArmInUse(
                    f"{name} is held by {holder_words(name)}: end that program, or stop the arm "
                    f"with `armdrive stop`"
                )
            self._locks.append(lock)

    def serve(self, answerer: Answerer) -> None:
        """Answer other programs of the same user about this arm.

        Raises `StateFileError` where nobody could find it: close the arm then, and `release` this.
        """
        try:
            self._listen(answerer)
        except OSError as error:
            raise StateFileError(
                f"other programs could not find out who holds {self._names[0]}: nothing can be "
                f"written beside {notice_path(self._names[0], 'holder')} "
                f"({error.strerror or error}); make room, or the folder writable"
            ) from None

    def _listen(self, answerer: Answerer) -> None:
        address = self._address()
        listener = Listener(address, backlog=MOST_WAITING)
        self._server = ControlServer(listener, answerer)
        self._listener = listener
        if os.name == "posix":
            Path(address).chmod(PRIVATE)
        notice = {
            "arm": self._names[0],
            "pid": os.getpid(),
            "program": _program(),
            "address": address,
        }
        for name in self._names:
            replace_file(notice_path(name, "holder"), json.dumps(notice))
        self._server.start()

    def release(self) -> None:
        """Give the arm to whoever wants it next."""
        listener, self._listener = self._listener, None
        server, self._server = self._server, None
        if server is not None and listener is not None:
            server.close()
            with contextlib.suppress(OSError):
                knock(str(listener.address))  # closing alone would not wake who waits for a call
            with contextlib.suppress(OSError):
                listener.close()
            for name in self._names:
                with contextlib.suppress(OSError):
                    notice_path(name, "holder").unlink()
        while self._locks:
            release_lock(self._locks.pop())
        folder, self._folder = self._folder, None
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)

    def _address(self) -> str:
        """Return where to listen: beside the lock, or in a folder of our own with a short path.

        Also in one of our own where others might get at what lies beside the lock.
        """
        address = address_of(self._names[0])
        if os.name != "posix":
            return address
        short = len(os.fsencode(address)) <= LONGEST_ADDRESS
        if not (short and is_private(Path(address).parent) and _cleared(Path(address))):
            self._folder = tempfile.mkdtemp(prefix="armdrive-")
            return str(Path(self._folder) / "socket")
        return address


def hold(*names: str) -> ArmLock:
    """Take the right to drive an arm, by all the names it goes by."""
    holding = ArmLock([name for name in dict.fromkeys(names) if name])
    holding.take()
    return holding


def _program() -> str:
    """Return what this program is called, also where Python runs a package of that name."""
    path = Path(sys.argv[0])
    return path.parent.name if path.name == "__main__.py" else path.name


def _cleared(address: Path) -> bool:
    """Make room for a socket, and tell whether there is: only a dead program's socket is removed.

    Nobody listens there any more, since this program has the lock.
    """
    try:
        if not stat.S_ISSOCK(address.lstat().st_mode):
            return False
        address.unlink()
    except FileNotFoundError:
        return True
    except OSError:
        return False
    return True
