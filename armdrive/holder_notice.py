"""Where the lock, the socket and the notice of the program are that holds an arm."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from armdrive import places

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
        notice = json.loads(notice_path(name, "holder").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return notice if isinstance(notice, dict) and "address" in notice else None


def holder_words(name: str) -> str:
    """Return the program that holds an arm, in words."""
    notice = notice_of(name)
    if notice is None:
        return "another program"
    return f"the program {notice.get('program')} (process {notice.get('pid')})"


def knock(address: str) -> None:
    """Call and hang up; raises `OSError` where nobody listens."""
    from multiprocessing.connection import Client

    Client(address).close()
