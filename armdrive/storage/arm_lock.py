"""Serves the control socket: any number of callers, few threads, and a stop that never waits.

One thread accepts, one reads all requests that are still incomplete. A caller that stays silent
costs a place among them and no thread, and loses the place when its time is over or when newer
callers need it. A stop is carried out by the reading thread itself; other requests are answered in
threads of their own, since a status waits for the engine, and a recording for the disk.

A request is one JSON object in UTF-8, and so is each answer. What they say is the business of the
`Answerer` that is passed in.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import stat
import struct
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from multiprocessing.connection import Connection, Listener, Pipe, wait
from pathlib import Path
from queue import Empty, Queue
from time import monotonic
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmInUse, StateFileError
from armdrive.storage import files as places
from armdrive.storage.files import create_lock, is_ours, is_private, replace_file
from armdrive.storage.lock_client import (
    AGAIN,
    PATIENCE_S,
    address_of,
    holder_words,
    knock,
    notice_path,
)
from armdrive.text.reading import PRIVATE

if TYPE_CHECKING:
    from filelock import FileLock

Json = dict[str, Any]

MOST_REQUEST_BYTES = 4096
"""Every request fits into a tenth of that."""

MOST_INCOMPLETE = 32
"""Callers that have not finished their request; a real one sends it with the call."""

MOST_ANSWERED = 8
"""Requests that are answered at a time, each in a thread. Watchers are counted apart."""

MOST_WATCHERS = 16
"""Programs that watch, follow or overhear an arm at a time, each in a thread."""

RETRY_S = 0.1
"""Between two attempts to accept a caller when the system has no room for one more."""

_LENGTH = struct.Struct("!i")
"""What goes before each message on a local socket: its length in bytes."""


class Answering(Enum):
    """How long a request takes, and so where it is answered."""

    AT_ONCE = "in the thread that reads all callers"
    IN_TURN = "by one object, in a thread"
    WATCHING = "by one object after another until either side ends, in a thread"


Answerer = Callable[[Json], tuple[Answering, Iterator[Json]]]
"""Tells how a request is answered, and answers it, from as many threads as there are callers."""


@dataclass(slots=True, eq=False)
class _Caller:
    """A caller whose request is incomplete; `until_s` is when its time is over."""

    connection: Connection[Any, Any]
    until_s: float
    received: bytearray = field(default_factory=bytearray)


class ControlServer:
    """Answers the callers of one listener until it is closed."""

    def __init__(self, listener: Listener, answerer: Answerer) -> None:
        """Take a listener, which its owner closes after `close`."""
        self._listener = listener
        self._answerer = answerer
        self._ended = threading.Event()
        self._accepted: Queue[Connection[Any, Any]] = Queue(MOST_INCOMPLETE)
        self._woken, self._wake = Pipe(duplex=False)
        self._callers: dict[Connection[Any, Any], _Caller] = {}
        self._answering = threading.BoundedSemaphore(MOST_ANSWERED)
        self._watching = threading.BoundedSemaphore(MOST_WATCHERS)

    @property
    def address(self) -> str:
        """Where callers reach this server."""
        return str(self._listener.address)

    def start(self) -> None:
        """Begin to answer."""
        for name, work in (("armdrive-socket", self._accept), ("armdrive-requests", self._read)):
            threading.Thread(target=work, name=name, daemon=True).start()

    def close(self) -> None:
        """Accept and read nothing more. The caller has to wake `accept` by a call of its own."""
        self._ended.set()
        with contextlib.suppress(OSError):
            self._wake.send_bytes(b"")

    # -- accepting ------------------------------------------------------------------------------

    def _accept(self) -> None:
        while not self._ended.is_set():
            try:
                connection = self._listener.accept()
            except (OSError, EOFError):
                self._ended.wait(RETRY_S)
                continue
            if self._ended.is_set() or not _may_call(connection):
                connection.close()
                continue
            self._accepted.put(connection)  # waits while the reading thread has enough to do
            with contextlib.suppress(OSError):
                self._wake.send_bytes(b"")

    # -- reading --------------------------------------------------------------------------------

    def _read(self) -> None:
        while not self._ended.is_set():
            for ready in wait([self._woken, *self._callers], self._patience_s()):
                if ready is self._woken:
                    self._woken.recv_bytes()
                elif (caller := self._callers.get(ready)) is not None:  # type: ignore[call-overload]
                    self._hear(caller)
            self._drop_silent()
            self._admit()
        for caller in self._callers.values():
            caller.connection.close()
        with contextlib.suppress(Empty):
            while True:
                self._accepted.get_nowait().close()

    def _patience_s(self) -> float | None:
        """Return how long to wait until somebody's time is over; None where nobody is there."""
        if not self._callers:
            return None
        first_s = min(caller.until_s for caller in self._callers.values())
        return max(first_s - monotonic(), 0.0)

    def _admit(self) -> None:
        """Take in who was accepted, and let those go that have been silent for longest."""
        for _ in range(MOST_INCOMPLETE):  # then the others are read again, however many come
            try:
                connection = self._accepted.get_nowait()
            except Empty:
                return
            self._callers[connection] = _Caller(connection, monotonic() + PATIENCE_S)
            while len(self._callers) > MOST_INCOMPLETE:
                self._make_room(next(iter(self._callers.values())))

    def _make_room(self, oldest: _Caller) -> None:
        """Let a caller go, unless its request has just come."""
        if _has_spoken(oldest):
            self._hear(oldest)
        if oldest.connection in self._callers:
            self._refuse(oldest, f"{MOST_INCOMPLETE} newer callers came: call again", again=True)

    def _drop_silent(self) -> None:
        now_s = monotonic()
        for caller in [each for each in self._callers.values() if each.until_s <= now_s]:
            self._refuse(caller, f"no whole request came within {PATIENCE_S:g} s")

    def _hear(self, caller: _Caller) -> None:
        """Take what has come, and answer a request that is whole."""
        try:
            request = _received(caller)
        except ValueError as error:
            self._refuse(caller, str(error))
        except (OSError, EOFError):
            self._forget(caller)
            caller.connection.close()
        else:
            if request is not None:
                self._forget(caller)
                self._answer(caller.connection, request)

    def _refuse(self, caller: _Caller, why: str, *, again: bool = False) -> None:
        self._forget(caller)
        _hang_up(caller.connection, why, again=again)

    def _forget(self, caller: _Caller) -> None:
        self._callers.pop(caller.connection, None)

    # -- answering ------------------------------------------------------------------------------

    def _answer(self, connection: Connection[Any, Any], request: bytes) -> None:
        """Answer a whole request: a stop here and now, anything else in a thread."""
        try:
            message = _parsed(request)
        except ValueError as error:
            _hang_up(connection, str(error))
            return
        way, answers = self._answerer(message)
        if way is Answering.AT_ONCE:
            self._reply(connection, answers)
            return
        if way is Answering.WATCHING:
            slots, full = self._watching, f"{MOST_WATCHERS} programs watch this arm already"
        else:
            slots, full = self._answering, f"{MOST_ANSWERED} requests are being answered already"
        if not slots.acquire(blocking=False):
            _hang_up(connection, f"{full}: try again later")
            return

        def reply() -> None:
            try:
                self._reply(connection, answers)
            finally:
                slots.release()

        try:
            threading.Thread(target=reply, name="armdrive-answer", daemon=True).start()
        except RuntimeError:  # the system has no thread to give
            slots.release()
            _hang_up(connection, "the program that holds the arm cannot begin one more thread")

    def _reply(self, connection: Connection[Any, Any], answers: Iterator[Json]) -> None:
        with connection, contextlib.suppress(OSError, EOFError):
            for answer in answers:
                connection.send_bytes(json.dumps(answer).encode())


def _parsed(data: bytes) -> Json:
    """Return what a request says. Raises `ValueError` with a sentence for what is no object."""
    try:
        message = json.loads(data.decode("utf-8"))
    except (ValueError, RecursionError):
        message = None
    if isinstance(message, dict):
        return message
    raise ValueError('a request is a JSON object in UTF-8, like {"request": "status"}')


def _may_call(connection: Connection[Any, Any]) -> bool:
    try:
        return is_ours(connection.fileno())
    except OSError:  # nothing left to ask the system with: better nobody than anybody
        return False


def _has_spoken(caller: _Caller) -> bool:
    try:
        return caller.connection.poll()
    except (OSError, EOFError):  # it has hung up
        return False


def _hang_up(connection: Connection[Any, Any], why: str, *, again: bool = False) -> None:
    """Tell a caller why, and close; a message this short never waits for its reader.

    `again` tells the caller that the same request may be answered at once if it is sent again.
    """
    answer = {"error": why, **({AGAIN: True} if again else {})}
    with connection, contextlib.suppress(OSError):
        connection.send_bytes(json.dumps(answer).encode())


def _received(caller: _Caller) -> bytes | None:
    """Read what is there without waiting; return the request once it is whole.

    Raises `EOFError`, `OSError`, and `ValueError` for one that is too long.
    """
    if os.name != "posix":
        return caller.connection.recv_bytes(MOST_REQUEST_BYTES)  # a pipe keeps messages whole
    most = _LENGTH.size + MOST_REQUEST_BYTES
    more = os.read(caller.connection.fileno(), most - len(caller.received))
    if not more:
        raise EOFError
    caller.received += more
    if len(caller.received) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack_from(caller.received)
    if not 0 <= length <= MOST_REQUEST_BYTES:
        raise ValueError(f"a request has at most {MOST_REQUEST_BYTES} bytes")
    whole = _LENGTH.size + length
    return bytes(caller.received[_LENGTH.size : whole]) if len(caller.received) >= whole else None


# One program holds an arm at a time; beside its lock stands a local socket for the same user.
#
# The lock goes by the port and the arm's name. Who answers callers is passed in. Messages are JSON
# objects; nothing is ever unpickled. The socket lies in a folder of this user's alone, and callers
# who are another user are hung up on, where the system tells.

MOST_WAITING = 16
"""Callers that the system lets wait until they are accepted, which takes no time."""

LONGEST_ADDRESS = 100
"""Bytes; the path of a local socket may have 103 on some systems, and 107 on others."""


class ArmLock:
    """The right to drive one arm, for as long as this program wants it."""

    def __init__(self, names: list[str]) -> None:
        self._names = names
        self._locks: list[FileLock] = []
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
        from filelock import FileLock, Timeout

        for name in self._names:
            path = notice_path(name, "lock")
            create_lock(path)  # filelock opens it as it is, and older ones follow a link
            lock = FileLock(path, mode=PRIVATE)
            try:
                lock.acquire(timeout=0)
            except Timeout:
                self.release()
                raise ArmInUse(
                    f"{name} is held by {holder_words(name)}: end that program, or stop the arm "
                    f"with `armdrive stop`"
                ) from None
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
        for lock in self._locks:
            lock.release()
        self._locks.clear()
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
