"""Send requests to the program that holds an arm, over its local socket.

That program decides which requests it accepts. Messages are JSON objects; nothing is ever
unpickled.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import socket
import struct
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError, ArmInUse, HolderError
from armdrive.errors.printable import reason_of
from armdrive.storage import files as places
from armdrive.storage.files import DISK, PRIVATE
from armdrive.text.reading import is_there

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Mapping
    from multiprocessing.connection import Connection

    from filelock import FileLock


# Where the holder of an arm keeps its lock, its socket and its notice.

LARGEST_BYTES = 65536  # of one answer, and of a notice
AGAIN = "again"  # key in an answer: the request was not read, and may be sent again
PATIENCE_S = 2.0  # hang up on a peer that has been silent this long
WATCH_EVERY_S = 0.2  # how often the holder looks for changes, unless the watcher asks otherwise


def names_of(*names: str) -> list[str]:
    """Return the names by which an arm is locked: its own, and the ports that links lead to.

    An empty name is left out: a simulated arm has no port.

    All links to a port share the port's name. Their own stay when the cable was pulled and a link
    leads nowhere, or to another port once it is back.
    """
    ports = (os.path.realpath(name) for name in names if name.startswith("/"))
    return list(dict.fromkeys(filter(None, (*names, *ports))))


def notice_path(name: str, ending: str) -> Path:
    """Return the path of a file of one of an arm's names."""
    return places.states() / f"{places.file_name(name)}.{ending}"


def try_lock(name: str) -> FileLock | None:
    """Take the lock of one of an arm's names; None if another program has it. Raises `OSError`."""
    from filelock import FileLock, Timeout

    path = notice_path(name, "lock")
    DISK.make_folder(path.parent)
    lock = FileLock(path, mode=PRIVATE)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        return None
    return lock


def address_of(name: str) -> str:
    """Return the default address of an arm's holder; its notice may name another."""
    if os.name == "posix":
        short = hashlib.blake2s(places.file_name(name).encode(), digest_size=8).hexdigest()
        return str(places.states() / f"{short}.socket")
    return rf"\\.\pipe\armdrive-{places.file_name(name)}"


def notice_of(*names: str) -> dict[str, Any] | None:
    """Return the notice that an arm's holder has written under one of its names, or None.

    The notice of a program that was killed counts only if no program holds the arm now.
    """
    notices = [*_notices(names_of(*names))]
    if len(notices) > 1:
        notices.sort(key=was_killed)
    return notices[0] if notices else None


def _notices(names: list[str]) -> Iterator[dict[str, Any]]:
    for each in reversed(names):  # who holds the port now comes first
        with contextlib.suppress(OSError, ValueError, RecursionError):
            notice = json.loads(DISK.read(notice_path(each, "holder"), LARGEST_BYTES))
            if isinstance(notice, dict) and "address" in notice:
                yield notice


def was_killed(notice: dict[str, Any]) -> bool:
    """Return whether nothing listens at a notice's address; a suspended program still does."""
    try:
        knock(str(notice["address"]))
    except (ConnectionRefusedError, FileNotFoundError, ValueError):  # or it is no address at all
        return True
    except (OSError, EOFError):  # the program has no time to answer
        return False
    return False


def name_held(*names: str) -> str:
    """Return the name by which a program holds an arm: the first of these if none holds it.

    A program that was started with the arm's port knows the arm by that port alone.
    """
    notice = notice_of(*names)
    return names[0] if notice is None else str(notice.get("arm", names[0]))


def is_held(name: str) -> bool:
    """Return whether a program holds an arm by this name and takes requests, if perhaps slowly."""
    return _live_notice(name) is not None


def _live_notice(name: str) -> dict[str, Any] | None:
    """Return the notice of the program that holds an arm by this name now, or None."""
    notice = notice_of(name)
    return None if notice is None or was_killed(notice) else notice


def holder_words(name: str) -> str:
    """Describe the program that holds an arm."""
    notice = notice_of(name)
    if notice is None:
        return "another program"
    return f"the program {notice.get('program')} (process {notice.get('pid')})"


def called(address: str) -> Connection[Any, Any]:
    """Connect to a listener. Raises `OSError` if none accepts within `PATIENCE_S`."""
    from multiprocessing.connection import Client, Connection

    if os.name != "posix":
        return Client(address)
    with socket.socket(socket.AF_UNIX) as end:
        # a suspended program accepts no connection; without a timeout its callers would hang
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, timeval(PATIENCE_S))
        end.connect(address)
        return Connection(end.detach())


def knock(address: str) -> None:
    """Connect and hang up; raises `OSError` if no program is listening."""
    called(address).close()


def timeval(time_s: float) -> bytes:
    """Return a duration as options of a socket hold it."""
    whole_s = int(time_s)
    return struct.pack("@ll", whole_s, int((time_s - whole_s) * 1e6))


CALLS = 60  # attempts at a request while other callers crowd it out
CALL_AGAIN_S = 0.05  # between attempts; all take longer than `PATIENCE_S`, when silent callers go


def ask_holder(name: str, request: str, **words: object) -> dict[str, Any]:
    """Send one of the requests in connect/control_socket.py to an arm's holder; return the answer.

    Raises `HolderError` if no program holds the arm.
    """
    for _ in range(CALLS):
        with _called(name) as connection:
            _send(connection, {"request": request, **words})
            answer = _heard(name, connection)
        if not answer.get(AGAIN):
            break
        time.sleep(CALL_AGAIN_S)
    return answer


def watch_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield the status of a held arm whenever it changes or its program has advanced.

    Ends when the holder releases the arm; closing this generator hangs up. Raises
    `HolderError` if no program holds the arm, or the holder refuses or stops answering.
    """
    with contextlib.closing(_streamed(name, "watch", every_s)) as answers:
        for answer in filter(None, answers):
            if "state" not in answer:
                raise HolderError(str(answer.get("error", "the program cannot be watched")))
            yield answer


def tap_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield the traffic on a held arm's wire (trace/entries.py), and `{}` while it is idle.

    Ends and raises like `watch_holder`.
    """
    return _streamed(name, "wire", every_s)


def _streamed(name: str, request: str, every_s: float) -> Generator[dict[str, Any], None, None]:
    with _called(name) as connection:
        try:
            _send(connection, {"request": request, "every_s": every_s})
            while True:
                yield _heard(name, connection, max(every_s, 0.0))
        except _HUNG_UP:
            return


# The peer has closed the connection; the last two if it had not read all that we sent.
_HUNG_UP = (EOFError, ConnectionResetError, BrokenPipeError)


@contextlib.contextmanager
def _called(name: str) -> Iterator[Connection[Any, Any]]:
    """Connect to an arm's holder and hang up at the end; every failure becomes an `HolderError`."""
    notice = notice_of(name)
    if notice is None:
        raise _unserved(name)
    try:
        with called(str(notice["address"])) as connection:
            yield connection
    except (ConnectionRefusedError, FileNotFoundError):
        raise HolderError(
            f"{holder_words(name)} held {name} and was killed before it could release it: "
            "nothing moves it from this computer any more"
        ) from None
    except (OSError, EOFError, ValueError) as error:
        raise HolderError(f"{holder_words(name)} cannot be asked: {reason_of(error)}") from None


def _unserved(name: str) -> ArmError:
    """Return the error for an arm whose holder, if it has one, has no socket."""
    if any(map(_is_locked, names_of(name))):
        return ArmInUse(
            f"{name} is held by a program that takes no requests: it is connecting, or "
            "diagnosing the arm. Stop that program with Ctrl-C, or the arm at its own switch"
        )
    return HolderError(f"no program holds {name}: nothing moves it from this computer")


def _is_locked(name: str) -> bool:
    """Return whether a program has the lock of a name; takes it for a moment to find out."""
    if not is_there(notice_path(name, "lock")):
        return False
    try:
        lock = try_lock(name)
    except OSError:  # no lock that this program could take either
        return False
    if lock is None:
        return True
    lock.release()
    return False


def _send(connection: Connection[Any, Any], request: Mapping[str, object]) -> None:
    """Send a request. A holder that has turned the caller away already has answered why."""
    with contextlib.suppress(BrokenPipeError):
        connection.send_bytes(json.dumps(request).encode())


def _heard(name: str, connection: Connection[Any, Any], longer_s: float = 0.0) -> dict[str, Any]:
    if not connection.poll(PATIENCE_S + longer_s):
        raise HolderError(f"{holder_words(name)} does not answer; stop the arm at its own switch")
    answer = json.loads(connection.recv_bytes(LARGEST_BYTES))
    return answer if isinstance(answer, dict) else {}


def held_arms() -> list[str]:
    """Return the names of all arms that programs hold now."""
    found: dict[str, str] = {}
    for path in sorted(places.states().glob("*.holder")):
        name = path.name.removesuffix(".holder")
        notice = _live_notice(name)
        if notice is not None:
            # an arm has two notices, by its name and by its port, with one address
            found[str(notice["address"])] = str(notice.get("arm", name))
    return list(found.values())
