"""What other programs ask of the one that holds an arm, over its local socket.

What may be asked is up to that program. Messages are JSON objects; nothing is ever unpickled.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import socket
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError
from armdrive.storage import files as places
from armdrive.storage.files import DISK, is_ours

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator
    from multiprocessing.connection import Connection


# Where the lock, the socket and the notice of the program are that holds an arm.

LARGEST_BYTES = 65536
AGAIN = "again"
"""In an answer: the request was not read, and may be sent again."""
PATIENCE_S = 2.0
"""Whoever is at the other end of a socket and says nothing for so long is hung up on."""
WATCH_EVERY_S = 0.2
"""The holder looks so often for a change, unless the watcher asks for another time."""


def notice_path(name: str, ending: str) -> Path:
    """Return an arm's file; a port goes by where its name leads, so that two links are one port."""
    name = os.path.realpath(name) if name.startswith("/") else name
    return places.states() / f"{places.file_name(name)}.{ending}"


def address_of(name: str) -> str:
    """Return where the holder of an arm listens, unless its notice says otherwise."""
    if os.name == "posix":
        short = hashlib.blake2s(places.file_name(name).encode(), digest_size=8).hexdigest()
        return str(places.states() / f"{short}.socket")
    return rf"\\.\pipe\armdrive-{places.file_name(name)}"


def notice_of(name: str) -> dict[str, Any] | None:
    """Return what the holder of an arm has written down of itself, None where there is nothing."""
    try:
        notice = json.loads(DISK.read_own(notice_path(name, "holder"), LARGEST_BYTES))
    except (OSError, ValueError, RecursionError):
        return None
    return notice if isinstance(notice, dict) and "address" in notice else None


def holder_words(name: str) -> str:
    """Return the program that holds an arm, in words."""
    notice = notice_of(name)
    if notice is None:
        return "another program"
    return f"the program {notice.get('program')} (process {notice.get('pid')})"


def called(address: str) -> Connection[Any, Any]:
    """Call who listens. Raises `OSError` where nobody does, or accepts no call for `PATIENCE_S`."""
    from multiprocessing.connection import Client, Connection

    if os.name != "posix":
        return Client(address)
    with socket.socket(socket.AF_UNIX) as end:
        # a program that is suspended accepts nobody, and would have its callers wait for ever
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _timeval(PATIENCE_S))
        end.connect(address)
        return Connection(end.detach())


def knock(address: str) -> None:
    """Call and hang up; raises `OSError` where nobody listens."""
    called(address).close()


def _timeval(time_s: float) -> bytes:
    whole_s = int(time_s)
    return struct.pack("@ll", whole_s, int((time_s - whole_s) * 1e6))


CALLS = 5
"""Calls before a request is given up that others crowd out."""


def ask_holder(name: str, request: str, **words: object) -> dict[str, Any]:
    """Ask the holder of an arm for what connect/control_socket.py lists.

    Raises `ArmError` where no program holds that arm.
    """
    for _ in range(CALLS):
        with _called(name) as connection:
            connection.send_bytes(json.dumps({"request": request, **words}).encode())
            answer = _heard(name, connection)
        if not answer.get(AGAIN):
            break
    return answer


def watch_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield the status of a held arm whenever it has changed, until its holder gives it back.

    Raises `ArmError` where none holds it, or the holder falls silent.
    """
    return _changes(name, "watch", every_s)


def follow_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield the status as `watch_holder` does, and whenever a program has come further as well."""
    return _changes(name, "follow", every_s)


def overhear_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield what passes on a held arm's wire (trace/wire_tap.py), and `{}` where nothing does.

    Ends, and raises, as `watch_holder` does.
    """
    return _streamed(name, "wire", every_s)


def _changes(name: str, request: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield what is not nothing; whoever closes this has hung up."""
    with contextlib.closing(_streamed(name, request, every_s)) as said:
        yield from filter(None, said)


def _streamed(name: str, request: str, every_s: float) -> Generator[dict[str, Any], None, None]:
    with _called(name) as connection:
        try:
            connection.send_bytes(json.dumps({"request": request, "every_s": every_s}).encode())
            while True:
                yield _heard(name, connection, max(every_s, 0.0))
        except _HUNG_UP:
            return


_HUNG_UP = (EOFError, ConnectionResetError, BrokenPipeError)
"""How the end of a call is met: the last two by a caller whose words were not read any more."""


@contextlib.contextmanager
def _called(name: str) -> Iterator[Connection[Any, Any]]:
    """Call the holder of an arm, and hang up at the end; every trouble becomes a sentence."""
    notice = notice_of(name)
    if notice is None:
        raise ArmError(f"no program holds {name}: nothing moves it from this computer")
    try:
        with called(str(notice["address"])) as connection:
            if not is_ours(connection.fileno()):
                raise ArmError(f"another user's program answers for {name}: it was asked nothing")
            yield connection
    except (ConnectionRefusedError, FileNotFoundError):
        raise ArmError(
            f"{holder_words(name)} held {name} and was ended without a chance to give it back: "
            "nothing moves it from this computer any more"
        ) from None
    except (OSError, EOFError, ValueError) as error:
        raise ArmError(f"{holder_words(name)} cannot be asked: {error}") from None


def _heard(name: str, connection: Connection[Any, Any], longer_s: float = 0.0) -> dict[str, Any]:
    if not connection.poll(PATIENCE_S + longer_s):
        raise ArmError(f"{holder_words(name)} does not answer; stop the arm at its own switch")
    answer = json.loads(connection.recv_bytes(65536))
    return answer if isinstance(answer, dict) else {}


def held_arms() -> list[str]:
    """Return the names under which programs hold arms now."""
    found: dict[str, str] = {}
    for path in sorted(places.states().glob("*.holder")):
        name = path.name.removesuffix(".holder")
        notice = notice_of(name) or {}
        address = str(notice.get("address"))
        with contextlib.suppress(OSError, EOFError):  # left behind by a program that was killed
            knock(address)
            found[address] = str(
                notice.get("arm", name)
            )  # an arm goes by its own name and by its port's
    return list(found.values())
