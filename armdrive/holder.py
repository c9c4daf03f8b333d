"""One program holds an arm at a time; beside its lock stands a local socket for the same user.

The lock goes by the port and the arm's name. The socket hands out the status, takes a stop
(`armdrive stop` from any terminal) and has a recording written (`armdrive record`). Messages are
JSON objects; nothing is ever unpickled.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import sys
import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive import places
from armdrive.errors import ArmError, ArmInUse

if TYPE_CHECKING:
    from multiprocessing.connection import Connection, Listener

    from filelock import FileLock

    from armdrive.arm import Arm

PATIENCE_S = 2.0
LONGEST_ADDRESS = 100
"""Bytes; the path of a local socket may have 103 on some systems, and 107 on others."""


class Holding:
    """The right to drive one arm, for as long as this program wants it."""

    def __init__(self, names: list[str]) -> None:
        self._names = names
        self._locks: list[FileLock] = []
        self._listener: Listener | None = None
        self._folder: str | None = None

    def take(self) -> None:
        """Take every lock or raise `ArmInUse` that names the holder."""
        from filelock import FileLock, Timeout

        places.states().mkdir(parents=True, exist_ok=True, mode=0o700)
        for name in self._names:
            lock = FileLock(_path(name, "lock"))
            try:
                lock.acquire(timeout=0)
            except Timeout:
                self.release()
                raise ArmInUse(
                    f"{name} is held by {_holder(name)}: end that program, or stop the arm with "
                    f"`armdrive stop`"
                ) from None
            self._locks.append(lock)

    def serve(self, arm: Arm) -> None:
        """Answer other programs of the same user about this arm."""
        from multiprocessing.connection import Listener

        address = self._address()
        with contextlib.suppress(OSError):
            Path(address).unlink()
        self._listener = Listener(address)
        if os.name == "posix":
            Path(address).chmod(0o600)
        notice = {
            "arm": self._names[0],
            "pid": os.getpid(),
            "program": Path(sys.argv[0]).name,
            "address": address,
        }
        for name in self._names:
            _path(name, "holder").write_text(json.dumps(notice), encoding="utf-8")
        threading.Thread(
            target=self._answer, args=(arm,), name="armdrive-socket", daemon=True
        ).start()

    def release(self) -> None:
        """Give the arm to whoever wants it next."""
        listener, self._listener = self._listener, None
        if listener is not None:
            with contextlib.suppress(OSError):
                _knock(str(listener.address))  # closing alone would not wake who waits for a call
            with contextlib.suppress(OSError):
                listener.close()
            for name in self._names:
                with contextlib.suppress(OSError):
                    _path(name, "holder").unlink()
        for lock in self._locks:
            lock.release()
        self._locks.clear()
        folder, self._folder = self._folder, None
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)

    def _address(self) -> str:
        """Return where to listen: beside the lock, or in a folder of our own with a short path."""
        address = _address(self._names[0])
        if os.name == "posix" and len(os.fsencode(address)) > LONGEST_ADDRESS:
            self._folder = tempfile.mkdtemp(prefix="armdrive-")
            return str(Path(self._folder) / "socket")
        return address

    def _answer(self, arm: Arm) -> None:
        while (listener := self._listener) is not None:
            try:
                connection = listener.accept()
            except (OSError, EOFError):
                continue
            # each call in a thread of its own: a stop does not wait behind somebody who is silent
            threading.Thread(target=_serve, args=(arm, connection), daemon=True).start()


def hold(*names: str) -> Holding:
    """Take the right to drive an arm, by all the names it goes by."""
    holding = Holding([name for name in dict.fromkeys(names) if name])
    holding.take()
    return holding


def ask_holder(name: str, request: str) -> dict[str, Any]:
    """Ask the holder of an arm: `status`, `stop` or `record`. Raises `ArmError` where none is."""
    from multiprocessing.connection import Client

    notice = _notice(name)
    if notice is None:
        raise ArmError(f"no program holds {name}: nothing moves it from this computer")
    try:
        with Client(str(notice["address"])) as connection:
            connection.send_bytes(json.dumps({"request": request}).encode())
            if not connection.poll(PATIENCE_S):
                raise ArmError(f"{_holder(name)} does not answer; stop the arm at its own switch")
            answer = json.loads(connection.recv_bytes(65536))
    except (ConnectionRefusedError, FileNotFoundError):
        raise ArmError(
            f"{_holder(name)} held {name} and was ended without a chance to give it back: nothing "
            "moves it from this computer any more"
        ) from None
    except (OSError, EOFError, ValueError) as error:
        raise ArmError(f"{_holder(name)} cannot be asked: {error}") from None
    return answer if isinstance(answer, dict) else {}


def held_arms() -> list[str]:
    """Return the names under which programs hold arms now."""
    found: dict[str, str] = {}
    for path in sorted(places.states().glob("*.holder")):
        name = path.name.removesuffix(".holder")
        notice = _notice(name) or {}
        address = str(notice.get("address"))
        with contextlib.suppress(OSError, EOFError):  # left behind by a program that was killed
            _knock(address)
            found[address] = str(
                notice.get("arm", name)
            )  # an arm goes by its own name and by its port's
    return list(found.values())


def _knock(address: str) -> None:
    """Call and hang up; raises `OSError` where nobody listens."""
    from multiprocessing.connection import Client

    Client(address).close()


def _serve(arm: Arm, connection: Connection[Any, Any]) -> None:
    with connection, contextlib.suppress(OSError, EOFError, ValueError):
        if connection.poll(PATIENCE_S):
            reply = _reply(arm, json.loads(connection.recv_bytes(4096)))
            connection.send_bytes(json.dumps(reply).encode())


def _reply(arm: Arm, message: Any) -> dict[str, Any]:
    request = message.get("request") if isinstance(message, dict) else None
    if request == "stop":
        arm.request_stop()
        return {"done": "stop"}
    if request == "status":
        from armdrive.view import status_view

        return status_view(arm.status)
    if request == "record":
        return _recorded(arm)
    return {"error": f"unknown request {request!r}; known are stop, status and record"}


def _recorded(arm: Arm) -> dict[str, Any]:
    """Have the flight recorder write into its own folder: no caller says where."""
    try:
        return {"recording": str(arm.save_recording())}
    except ArmError as error:
        return {"error": str(error)}


def _path(name: str, ending: str) -> Path:
    return places.states() / f"{places.file_name(name)}.{ending}"


def _address(name: str) -> str:
    if os.name == "posix":
        short = hashlib.blake2s(places.file_name(name).encode(), digest_size=8).hexdigest()
        return str(places.states() / f"{short}.socket")
    return rf"\\.\pipe\armdrive-{places.file_name(name)}"


def _notice(name: str) -> dict[str, Any] | None:
    try:
        notice = json.loads(_path(name, "holder").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return notice if isinstance(notice, dict) and "address" in notice else None


def _holder(name: str) -> str:
    notice = _notice(name)
    if notice is None:
        return "another program"
    return f"the program {notice.get('program')} (process {notice.get('pid')})"
