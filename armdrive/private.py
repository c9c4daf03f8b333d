"""What is this user's alone: a folder that nobody else gets into, a caller who is nobody else."""

from __future__ import annotations

import os
import socket
import stat
import struct
from pathlib import Path

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
