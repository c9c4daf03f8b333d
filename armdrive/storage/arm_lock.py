"""The lock on an arm, and the control socket on which its holder answers other programs.

One thread accepts callers, and each caller has a thread that reads its request and answers it. Far
fewer programs may watch an arm than may call at a time: so watchers keep no stop waiting.

A request is one JSON object in UTF-8, and so is each answer. The `Answerer` passed to the server
gives them their meaning.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, Listener
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmInUse, StateFileError
from armdrive.errors.printable import reason_of
from armdrive.storage import files as places
from armdrive.storage.files import PRIVATE, replace_file
from armdrive.storage.lock_client import (
    AGAIN,
    PATIENCE_S,
    address_of,
    holder_words,
    knock,
    names_of,
    notice_of,
    notice_path,
    timeval,
    try_lock,
)

if TYPE_CHECKING:
    from filelock import FileLock

Json = dict[str, Any]

MOST_REQUEST_BYTES = 4096  # ten times the longest request
MOST_CALLERS = 64  # at a time, each in a thread
MOST_WATCHERS = 16  # programs that watch or tap an arm at a time
RETRY_S = 0.1  # pause after a failed accept, for instance when the system has no file handle left


# Returns whether a request watches the arm, and the answers. Called from several threads at once.
Answerer = Callable[[Json], tuple[bool, Iterator[Json]]]


class ControlServer:
    """Answers the callers of one listener until `close`."""

    def __init__(self, listener: Listener, answerer: Answerer) -> None:
        """Serve a listener. The owner of the listener closes it after `close`."""
        self._listener = listener
        self._answerer = answerer
        self._ended = threading.Event()
        self._callers = threading.BoundedSemaphore(MOST_CALLERS)
        self._watchers = threading.BoundedSemaphore(MOST_WATCHERS)

    def start(self) -> None:
        """Start answering callers."""
        threading.Thread(target=self._accept, name="armdrive-socket", daemon=True).start()

    def close(self) -> None:
        """Accept no more callers. Connect once afterwards to wake the blocked `accept`."""
        self._ended.set()

    def _accept(self) -> None:
        while not self._ended.is_set():
            try:
                connection = self._listener.accept()
            except (OSError, EOFError):
                self._ended.wait(RETRY_S)
                continue
            if self._ended.is_set():
                connection.close()
            elif not self._callers.acquire(blocking=False):
                _turn_away(connection)
            else:
                self._start_answering(connection)

    def _start_answering(self, connection: Connection[Any, Any]) -> None:
        work = threading.Thread(
            target=self._answer, args=(connection,), name="armdrive-answer", daemon=True
        )
        try:
            work.start()
        except RuntimeError:  # the system is out of threads
            self._callers.release()
            _turn_away(connection)

    def _answer(self, connection: Connection[Any, Any]) -> None:
        """Read one request, and answer it."""
        try:
            with connection, contextlib.suppress(OSError, EOFError):  # the caller has hung up
                try:
                    watches, answers = self._answerer(_request(connection))
                except ValueError as error:
                    _send(connection, {"error": str(error)})
                    return
                if not watches:
                    _send_all(connection, answers)
                elif self._watchers.acquire(blocking=False):
                    try:
                        _send_all(connection, answers)
                    finally:
                        self._watchers.release()
                else:
                    words = f"{MOST_WATCHERS} programs watch this arm already: try again later"
                    _send(connection, {"error": words})
        finally:
            self._callers.release()


def _send(connection: Connection[Any, Any], answer: Json) -> None:
    connection.send_bytes(json.dumps(answer).encode())


def _send_all(connection: Connection[Any, Any], answers: Iterator[Json]) -> None:
    for answer in answers:
        _send(connection, answer)


def _request(connection: Connection[Any, Any]) -> Json:
    """Return a caller's request.

    Raises `ValueError` for none within `PATIENCE_S`, or one that cannot be read; `OSError` and
    `EOFError` if the caller has hung up.
    """
    _limit_reading(connection)
    try:
        data = connection.recv_bytes(MOST_REQUEST_BYTES) if connection.poll(PATIENCE_S) else None
    except BlockingIOError:  # the rest of a message has not come
        data = None
    except ConnectionError:
        raise
    except OSError:  # what `multiprocessing` raises for a message that is longer
        raise ValueError(f"a request has at most {MOST_REQUEST_BYTES} bytes") from None
    if data is None:
        raise ValueError(f"no complete request arrived within {PATIENCE_S:g} s")
    try:
        message = json.loads(data.decode("utf-8"))
    except (ValueError, RecursionError):
        message = None
    if isinstance(message, dict):
        return message
    raise ValueError('a request is a JSON object in UTF-8, like {"request": "status"}')


def _limit_reading(connection: Connection[Any, Any]) -> None:
    """Let no read wait longer than `PATIENCE_S` for the rest of a request.

    On Windows none does: its pipes keep messages whole.
    """
    if os.name == "posix":
        with socket.socket(fileno=os.dup(connection.fileno())) as end:
            end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, timeval(PATIENCE_S))


def _turn_away(connection: Connection[Any, Any]) -> None:
    """Tell a caller to call again, and close the connection. So short a message never blocks."""
    with connection, contextlib.suppress(OSError):
        _send(connection, {"error": f"{MOST_CALLERS} programs call already", AGAIN: True})


# Only one program at a time holds an arm. Next to its lock is a local socket for the same user.
#
# An arm is locked by its port and by its name, and a link to a port by both. Messages are JSON
# objects; nothing is ever unpickled. The socket lies in a private folder.

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
        self._notices: list[Path] = []

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
        self._notices = [notice_path(name, "holder") for name in self._names]
        for path in self._notices:
            replace_file(path, json.dumps(notice))
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
            for path in self._notices:
                with contextlib.suppress(OSError):
                    path.unlink()
        for lock in self._locks:
            lock.release()
        self._locks.clear()
        folder, self._folder = self._folder, None
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)

    def _address(self) -> str:
        """Return where to listen: beside the lock, or in a temporary folder if its path is long."""
        address = address_of(self._names[0])
        if os.name != "posix":
            return address
        if len(os.fsencode(address)) > LONGEST_ADDRESS:
            self._folder = tempfile.mkdtemp(prefix="armdrive-")
            return str(Path(self._folder) / "socket")
        # a killed program left it: as this program has the lock, no other one listens there
        Path(address).unlink(missing_ok=True)
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
