"""Where arm files, points and remembered states live on this computer.

`ARMDRIVE_HOME` in the environment moves both into one folder, for tests and for shared computers.
"""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path


def arm_files() -> Path:
    """Return the folder of arm files."""
    return _folder("config") / "arms"


def key_file() -> Path:
    """Return the file in which a person gives the desk other keys."""
    return _folder("config") / "keys.toml"


def points_file(arm: str) -> Path:
    """Return the file of an arm's named points: beside the folder of arm files, one an arm."""
    return _folder("config") / "points" / f"{file_name(arm)}.toml"


def states() -> Path:
    """Return the folder of remembered positions, simulated worlds, locks and sockets."""
    return _folder("state")


def file_name(arm: str) -> str:
    """Return a file name for an arm, another one for every name, whatever characters it has.

    Without capitals and dots: some disks tell no capitals apart, and endings are ours to give.
    """
    plain = re.sub(r"[^a-z0-9_-]+", "_", arm.lower()).strip("_")
    if plain == arm:
        return plain
    # a word of the command line has lone surrogates where its bytes are no UTF-8
    digest = hashlib.sha256(arm.encode("utf-8", "surrogatepass")).hexdigest()
    return f"{plain or 'arm'}-{digest[:8]}"


def _folder(kind: str) -> Path:
    home = os.environ.get("ARMDRIVE_HOME")
    if home:
        return Path(home) / kind
    import platformdirs

    if kind == "config":
        return platformdirs.user_config_path("armdrive", appauthor=False)
    return platformdirs.user_state_path("armdrive", appauthor=False)
