"""Recording files: JSON lines, replaced atomically, with the oldest files deleted.

The first line is the header, every other line an entry. Bytes are stored as text, one character per
byte (Latin-1), so that a person can read most of them.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any

from armdrive.config.arm import ArmConfig, ConfigSource
from armdrive.config.sections import is_model_file
from armdrive.config.write import complete
from armdrive.errors import ArmError, ArmFileError, RecordingError, StateFileError
from armdrive.errors.printable import reason_of
from armdrive.storage import files as places
from armdrive.storage.files import DISK, replace_durably
from armdrive.text.reading import read_bytes, read_text
from armdrive.text.toml import section_of, setting
from armdrive.trace.entries import TRAFFIC, EntryKind, TraceEntry
from kinematics.errors import KinematicsError

# The header names the arm and contains its whole arm file, so that a replay needs nothing else.

FORMAT = 1
LATEST_S = 1e8  # three years: no arm's clock runs that long
MARK = "armdrive_recording"  # the key that identifies a recording; its value is the format number


@dataclass(frozen=True, slots=True)
class Header:
    """The header of a recording.

    `began` is the wall-clock time of the connection (UTC, ISO 8601), `began_s` the arm's own time
    then. `arm_file` is TOML with every default filled in, or empty if it could not be written;
    `model_file` is the text of the model file that the arm file names, if any.
    """

    version: str
    why: str
    arm: str
    title: str
    dialect: str
    link: str
    calibration: str
    began: str
    began_s: float = setting(low=-LATEST_S, high=LATEST_S)
    arm_file: str = setting()
    model_file: str = setting()


def header_of(config: ArmConfig, *, link: str, why: str, began: tuple[float, float]) -> Header:
    """Return the header of a recording; `began` holds the wall-clock time and the arm's time."""
    wall_s, began_s = began
    moment = dt.datetime.fromtimestamp(wall_s, dt.UTC)
    arm_file, model_file = texts_of(config)
    return Header(
        version=version("armdrive"),
        why=why,
        arm=config.name,
        title=config.title,
        dialect=config.connection.dialect,
        link=link,
        calibration=config.calibration,
        began=moment.isoformat(timespec="milliseconds"),
        began_s=began_s,
        arm_file=arm_file,
        model_file=model_file,
    )


def texts_of(config: ArmConfig) -> tuple[str, str]:
    """Return an arm as TOML and the text of its model file; empty texts if either fails.

    A recording is written when something has gone wrong, and is useful even without them.
    """
    source = config.source
    if source is None:
        return "", ""
    table: dict[str, Any] = dict(source.table)
    word = str(table.get("model", ""))
    try:
        text = complete(config, table)
        model = _model_text(source, word) if is_model_file(word) else ""
    except (ArmError, KinematicsError, ArithmeticError, LookupError, OSError, ValueError):
        return "", ""
    return text, model


def _model_text(source: ConfigSource, word: str) -> str:
    return read_text(source.folder / word, "the model file", ArmFileError)


# Writing.

ENDING = ".jsonl"
LINES_AT_A_TIME = 1000  # a system call each
MOST_FILES = 20  # beyond this number the oldest recordings are deleted


def free_path(folder: Path | None, header: Header) -> Path:
    """Return an unused path that names the arm, its connection time, and the reason to write."""
    folder = folder or places.recordings()
    moment = re.sub(r"[^0-9]", "", header.began[:19])
    why = re.sub(r"[^a-z]+", "-", header.why)
    for number in range(1, 1000):
        path = folder / f"{places.file_name(header.arm)}-{moment}-{number:03}-{why}{ENDING}"
        if not any(folder.glob(f"{places.file_name(header.arm)}-{moment}-{number:03}-*")):
            break
    return path


def lines_of(header: Header, entries: Iterable[TraceEntry]) -> Iterator[str]:
    """Yield the lines of a recording, without line ends."""
    yield json.dumps({MARK: FORMAT, **asdict(header)})
    for time_s, kind, what in entries:
        wire = isinstance(what, bytes)
        text = what.decode("latin-1") if isinstance(what, bytes) else what
        yield json.dumps({"t": time_s, "kind": kind.value, "bytes" if wire else "text": text})


def write_recording(
    path: Path, header: Header, entries: Iterable[TraceEntry], *, most: Path | None = None
) -> None:
    """Write a file atomically. Raises `StateFileError`.

    In the folder `most`, all but the latest `MOST_FILES` recordings are deleted.
    """
    try:
        replace_durably(DISK, path, _pieces(lines_of(header, entries)))
    except OSError as error:
        raise StateFileError(
            f"the recording {path} cannot be written: {reason_of(error)}"
        ) from None
    if most is not None:
        _delete_oldest(most)


def _pieces(lines: Iterator[str]) -> Iterator[bytes]:
    """Yield the bytes of a file, many lines at a time: each piece costs one system call."""
    while some := list(islice(lines, LINES_AT_A_TIME)):
        yield "".join(f"{line}\n" for line in some).encode()


def _delete_oldest(folder: Path) -> None:
    with contextlib.suppress(OSError):
        found = sorted(folder.glob(f"*{ENDING}"), key=lambda path: path.stat().st_mtime_ns)
        for path in found[:-MOST_FILES]:
            path.unlink(missing_ok=True)


# Strict reading: anything broken is a `RecordingError` that names the line.
#
# A truncated last line is no error, because a copy of a file may have ended early. Nothing that a
# recording names is opened or executed: the arm file and its model file are text in the header.

MOST_FILE_BYTES = 64_000_000  # JSON makes at most six times as much of the ring's 4 MB
LONGEST_HEADER = 2_000_000  # bytes: an arm file and a model file of 300 kB each, as JSON
_KINDS = {kind.value: kind for kind in EntryKind}


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording as read from a file; `cut_off` if the last line was truncated."""

    header: Header
    entries: tuple[TraceEntry, ...]
    cut_off: bool = False


def read_recording(path: Path) -> Recording:
    """Read a file. Raises `RecordingError`."""
    data = read_bytes(path, "the recording", RecordingError, most_bytes=MOST_FILE_BYTES)
    try:
        return parse_recording(data)
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from None


def parse_recording(data: bytes) -> Recording:
    """Turn a file's bytes into a recording. Raises `RecordingError`."""
    lines = io.BytesIO(data)  # line by line: a huge file of empty lines is refused at once
    header = _header(lines.readline(LONGEST_HEADER).removesuffix(b"\n"))
    entries = tuple(_entries(lines))
    return Recording(header, entries, cut_off=not data.endswith(b"\n"))


def _object(line: bytes) -> dict[str, Any]:
    """Return the JSON object of a line; an empty one if it holds none."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _header(line: bytes) -> Header:
    found = _object(line)
    known = found.pop(MARK, None)
    if known is None:
        raise RecordingError("the file is not a flight recording")
    if type(known) is not int or known != FORMAT:  # neither true nor 1.0 is a format
        raise RecordingError(f"the format is {known!r:.20}, but this armdrive reads {FORMAT}")
    try:
        return section_of(Header, found, "line 1")
    except ArmFileError as error:
        raise RecordingError(str(error)) from None


def _entries(lines: Iterable[bytes]) -> Iterator[TraceEntry]:
    """Yield an entry for each complete line; a truncated last line is left out."""
    latest_s = -math.inf
    for number, line in enumerate(lines, 2):
        if not line.endswith(b"\n"):
            return
        entry = _entry(_object(line), number)
        if entry.time_s < latest_s:
            raise RecordingError(f"line {number} has an earlier time than the previous line")
        latest_s = entry.time_s
        yield entry


def _entry(found: Mapping[str, Any], number: int) -> TraceEntry:
    """Return the entry of a line. Raises `RecordingError`, whatever is wrong with it."""
    try:
        kind, time_s = _KINDS[found["kind"]], found["t"]
        what = found["bytes"].encode("latin-1") if kind in TRAFFIC else found["text"]
        number_given = isinstance(time_s, int | float) and not isinstance(time_s, bool)
        # NaN is not within bounds either
        right = number_given and abs(time_s) <= LATEST_S and isinstance(what, bytes | str)
    except (AttributeError, KeyError, TypeError, ValueError):
        right = False
    if not right:
        raise RecordingError(
            f"line {number} is no entry, with a time `t`, a `kind`, and `bytes` or `text`"
        )
    return TraceEntry(float(time_s), kind, what)
