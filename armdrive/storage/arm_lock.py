"""The lock on an arm and its control socket, which serves many callers and never delays a stop.

One thread accepts connections; another reads all requests that are still incomplete. A silent
caller takes one of a fixed number of places, but no thread, and loses its place after a timeout or
when newer callers need it. The reading thread carries out a stop itself. Every other request is
answered in its own thread, because a status waits for the engine and a recording for the disk.

A request is one JSON object in UTF-8, and so is each answer. The `Answerer` passed to the server
gives them their meaning.
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
from armdrive.errors.printable import reason_of
from armdrive.storage import files as places
from armdrive.storage.files import is_ours, is_private, replace_file
from armdrive.storage.lock_client import (
    AGAIN,
    PATIENCE_S,
    address_of,
    holder_words,
    knock,
    names_of,
    notice_of,
    notice_path,
    try_lock,
)
from armdrive.text.reading import PRIVATE

if TYPE_CHECKING:
    from filelock import FileLock

Json = dict[str, Any]

MOST_REQUEST_BYTES = 4096  # ten times the longest request
MOST_INCOMPLETE = 32  # callers with an unfinished request; a real caller sends it on connecting
MOST_ANSWERED = 8  # requests answered at a time, each in a thread; watchers have their own limit
MOST_WATCHERS = 16  # programs that watch, follow or tap an arm at a time, each in a thread
RETRY_S = 0.1  # pause after a failed accept, for instance when the system has no file handle left

_LENGTH = struct.Struct("!i")  # the length in bytes, which precedes each message on a local socket


class Answering(Enum):
    """Where a request is answered, which depends on how long the answer takes."""

    AT_ONCE = "in the thread that reads all callers"
    IN_TURN = "with one object, in a thread"
    WATCHING = "with a stream of objects until either side ends, in a thread"


Answerer = Callable[[Json], tuple[Answering, Iterator[Json]]]
"""Returns how to answer a request, and the answers. Called from several threads at once."""


@dataclass(slots=True, eq=False)
class _Caller:
    """A caller with an incomplete request; it times out at `until_s`."""

    connection: Connection[Any, Any]
    until_s: float
    received: bytearray = field(default_factory=bytearray)


class ControlServer:
    """Answers the callers of one listener until `close`."""

    def __init__(self, listener: Listener, answerer: Answerer) -> None:
        """Serve a listener. The owner of the listener closes it after `close`."""
        self._listener = listener
        self._answerer = answerer
        self._ended = threading.Event()
        self._accepted: Queue[Connection[Any, Any]] = Queue(MOST_INCOMPLETE)
        self._woken, self._wake = Pipe(duplex=False)
        self._callers: dict[Connection[Any, Any], _Caller] = {}
        self._answering = threading.BoundedSemaphore(MOST_ANSWERED)
        self._watching = threading.BoundedSemaphore(MOST_WATCHERS)

    def start(self) -> None:
        """Start answering callers."""
        for name, work in (("armdrive-socket", self._accept), ("armdrive-requests", self._read)):
            threading.Thread(target=work, name=name, daemon=True).start()

    def close(self) -> None:
        """Stop accepting and reading. Connect once afterwards to wake the blocked `accept`."""
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
            self._accepted.put(connection)  # blocks while the reading thread is behind
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
            # Requests are read before callers are dropped, so that none is dropped whose request
            # has arrived meanwhile.
            self._drop_silent()
            self._admit()
        for caller in self._callers.values():
            caller.connection.close()
        with contextlib.suppress(Empty):
            while True:
                self._accepted.get_nowait().close()

    def _patience_s(self) -> float | None:
        """Return the time until the next caller times out; None without callers."""
        if not self._callers:
            return None
        first_s = min(caller.until_s for caller in self._callers.values())
        return max(first_s - monotonic(), 0.0)

    def _admit(self) -> None:
        """Admit newly accepted callers, and drop those that have been silent the longest."""
        for _ in range(MOST_INCOMPLETE):  # a limit, so that a flood cannot starve the others
            try:
                connection = self._accepted.get_nowait()
            except Empty:
                return
            self._callers[connection] = _Caller(connection, monotonic() + PATIENCE_S)
            while len(self._callers) > MOST_INCOMPLETE:
                self._make_room(next(iter(self._callers.values())))

    def _make_room(self, oldest: _Caller) -> None:
        """Drop a caller, unless the rest of its request has just arrived."""
        if _has_spoken(oldest):
            self._hear(oldest)
        if oldest.connection in self._callers:
            self._refuse(oldest, f"{MOST_INCOMPLETE} newer callers arrived: call again", again=True)

    def _drop_silent(self) -> None:
        now_s = monotonic()
        for caller in [each for each in self._callers.values() if each.until_s <= now_s]:
            self._refuse(caller, f"no complete request arrived within {PATIENCE_S:g} s")

    def _hear(self, caller: _Caller) -> None:
        """Read what has arrived, and answer the request once it is complete."""
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
        """Answer a complete request: a stop on this thread, anything else on a new one."""
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
        except RuntimeError:  # the system is out of threads
            slots.release()
            _hang_up(connection, "the program that holds the arm cannot start another thread")

    def _reply(self, connection: Connection[Any, Any], answers: Iterator[Json]) -> None:
        with connection, contextlib.suppress(OSError, EOFError):
            for answer in answers:
                connection.send_bytes(json.dumps(answer).encode())


def _parsed(data: bytes) -> Json:
    """Return a request's JSON object. Raises `ValueError` for anything else."""
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
    except OSError:  # out of file handles: refuse a caller whose user cannot be checked
        return False


def _has_spoken(caller: _Caller) -> bool:
    try:
        return caller.connection.poll()
    except (OSError, EOFError):  # the caller has hung up
        return False


def _hang_up(connection: Connection[Any, Any], why: str, *, again: bool = False) -> None:
    """Send a caller the reason, and close the connection. So short a message never blocks.

    `again` means that sending the same request again may succeed at once.
    """
    answer = {"error": why, **({AGAIN: True} if again else {})}
    with connection, contextlib.suppress(OSError):
        connection.send_bytes(json.dumps(answer).encode())


def _received(caller: _Caller) -> bytes | None:
    """Read without waiting; return the request once it is complete.

    Raises `EOFError`, `OSError`, or `ValueError` for a request that is too long.
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


# Only one program at a time holds an arm. Next to its lock is a local socket for the same user.
#
# An arm is locked by its port and by its name, and a link to a port by both. Messages are JSON
# objects; nothing is ever unpickled. The socket lies in a private folder, and callers of another
# user are hung up on, where the system reveals the caller's user.

MOST_WAITING = 16  # connections that the system queues until they are accepted
LONGEST_ADDRESS = 100  # bytes; systems limit the path of a local socket to 103 or 107


class ArmLock(contextlib.AbstractContextManager["ArmLock"]):
    """The exclusive right to drive one arm; leaving a `with` block releases it."""

    def __init__(self, names: list[str]) -> None:
        self._names = names
        self._locks: list[FileLock] = []
        self._listener: Listener | None = None
        self._server: ControlServer | None = None
        self._folder: str | None = None

    def __exit__(self, *_: object) -> None:
        self.release()

    def take(self) -> None:
        """Take every lock, or raise `ArmInUse` that names the holder."""
        try:
            self._take_all()
        except OSError as error:
            self.release()
            raise StateFileError(
                f"no arm can be locked, because {places.states()} is not writable "
                f"({reason_of(error)}): make it writable, or set ARMDRIVE_HOME to a "
                "writable folder"
            ) from None

    def _take_all(self) -> None:
        for name in self._names:
            lock = try_lock(name)
            if lock is None:
                self.release()
                if (notice_of(name) or {}).get("pid") == os.getpid():
                    raise ArmInUse(
                        f"{name} is held by this program: use that connection, or close it first"
                    )
                raise ArmInUse(
                    f"{name} is held by {holder_words(name)}: close that connection, end that "
                    f"program, or stop the arm with `armdrive stop`"
                )
            self._locks.append(lock)
            with contextlib.suppress(OSError):
                # a program that was killed left it, and would be taken for the holder
                notice_path(name, "holder").unlink(missing_ok=True)

    def serve(self, answerer: Answerer) -> None:
        """Answer other programs of the same user about this arm.

        Raises `StateFileError` if they could not find the socket: then close the arm and
        `release` the lock.
        """
        try:
            self._listen(answerer)
        except OSError as error:
            raise StateFileError(
                f"other programs could not find the holder of {self._names[0]}: "
                f"{notice_path(self._names[0], 'holder')} cannot be written "
                f"({reason_of(error)}); free disk space, or make the folder writable"
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
        # Callers that have read the notice by now wait in the listener's queue.
        self._server.start()

    def release(self) -> None:
        """Release the arm for other programs."""
        listener, self._listener = self._listener, None
        server, self._server = self._server, None
        # The socket and its notices go before the locks: the next holder makes its own.
        if server is not None and listener is not None:
            server.close()
            with contextlib.suppress(OSError):
                knock(str(listener.address))  # closing alone would not end the blocked accept
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
        """Return where to listen: next to the lock, or in a temporary private folder.

        The latter if the path is too long, the folder of the lock is open to other users, or
        something other than an old socket is in the way.
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
    """Lock an arm under all its names."""
    holding = ArmLock(names_of(*names))
    holding.take()
    return holding


def _program() -> str:
    """Return this program's name; for `python -m NAME` the name of the package."""
    path = Path(sys.argv[0])
    return path.parent.name if path.name == "__main__.py" else path.name


def _cleared(address: Path) -> bool:
    """Remove the socket of a dead program; return whether the address is free.

    As this program has the lock, no other program can be listening there.
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
