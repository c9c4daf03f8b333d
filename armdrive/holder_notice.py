"""Where the lock, the socket and the notice of the program are that holds an arm."""

from __future__ import annotations

import hashlib
import json
import os
import socket
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive import places
from armdrive.durable import DISK

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

LARGEST_BYTES = 65536
AGAIN = "again"
"""In an answer: the request was not read, and may be sent again."""
PATIENCE_S = 2.0
"""Whoever is at the other end of a socket and says nothing for so long is hung up on."""


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
