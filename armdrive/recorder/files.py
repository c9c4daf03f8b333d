"""Recordings on the disk: JSON lines, written whole or not at all, the oldest of them deleted.

The first line is the header, each other line an entry. Bytes stand as text, one character a byte
(Latin-1), so that a person can read most of them.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from itertools import islice
from pathlib import Path

from armdrive import places
from armdrive.durable import DISK, replace_durably
from armdrive.errors import StateFileError
from armdrive.recorder.entries import Entry
from armdrive.recorder.header import FORMAT, MARK, Header

ENDING = ".jsonl"
LINES_AT_A_TIME = 1000
MOST_FILES = 20
"""So many recordings are kept; the oldest go."""


def recordings() -> Path:
    """Return the folder into which recordings are written where no other is named."""
    return places.states() / "recordings"


def free_path(folder: Path | None, header: Header) -> Path:
    """Return a file name that says which arm, when it was connected, and why it was written."""
    folder = folder or recordings()
    moment = re.sub(r"[^0-9]", "", header.began[:19])
    why = re.sub(r"[^a-z]+", "-", header.why)
    for number in range(1, 1000):
        path = folder / f"{places.file_name(header.arm)}-{moment}-{number:03}-{why}{ENDING}"
        if not any(folder.glob(f"{places.file_name(header.arm)}-{moment}-{number:03}-*")):
            break
    return path


def lines_of(header: Header, entries: Iterable[Entry]) -> Iterator[str]:
    """Return the lines of a file, without their ends."""
    yield json.dumps({MARK: FORMAT, **asdict(header)})
    for time_s, kind, what in entries:
        wire = isinstance(what, bytes)
        text = what.decode("latin-1") if isinstance(what, bytes) else what
        yield json.dumps({"t": time_s, "kind": kind.value, "bytes" if wire else "text": text})


def write_recording(
    path: Path, header: Header, entries: Iterable[Entry], *, most: Path | None = None
) -> None:
    """Write a file, whole or not at all. Raises `StateFileError`.

    In the folder `most` no more than `MOST_FILES` are left.
    """
    try:
        replace_durably(DISK, path, _pieces(lines_of(header, entries)))
    except OSError as error:
        raise StateFileError(f"the recording {path} cannot be written: {error}") from None
    if most is not None:
        _delete_oldest(most)


def _pieces(lines: Iterator[str]) -> Iterator[bytes]:
    """Return the bytes of a file, many lines at a time: each piece is a call of the system."""
    while some := list(islice(lines, LINES_AT_A_TIME)):
        yield "".join(f"{line}\n" for line in some).encode()


def _delete_oldest(folder: Path) -> None:
    with contextlib.suppress(OSError):
        found = sorted(folder.glob(f"*{ENDING}"), key=lambda path: path.stat().st_mtime_ns)
        for path in found[:-MOST_FILES]:
            path.unlink(missing_ok=True)
