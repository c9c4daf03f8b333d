"""Reading a recording, strictly: whatever is broken in it is a `RecordingError` that says where.

A last line that was cut off is no error: the copy of a file may have ended too early. Nothing that
a recording names is opened or run: the arm file and its model file stand in it as text.
"""

from __future__ import annotations

import io
import json
import math
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError, RecordingError
from armdrive.recorder.entries import WIRE, Entry, Kind
from armdrive.recorder.header import FORMAT, MARK, Header
from armdrive.textfile import parse_toml, read_bytes
from kinematics.errors import KinematicsError

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig

MOST_FILE_BYTES = 64_000_000
LATEST_S = 1e8
"""No arm's clock has ever shown more: three years."""
_KINDS = {kind.value: kind for kind in Kind}


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording as it was read; `cut_off` says that its last line was not whole."""

    header: Header
    entries: tuple[Entry, ...]
    cut_off: bool = False

    def config(self) -> ArmConfig:
        """Return the arm as its own file describes it. Raises `RecordingError`."""
        from armdrive.armfile import parse_arm_file

        header = self.header
        if not header.arm_file:
            raise RecordingError(
                "the recording holds no arm file, so that no simulated twin can be made of it; "
                "--show still prints it"
            )
        try:
            table = parse_toml(header.arm_file, RecordingError)
            with tempfile.TemporaryDirectory(prefix="armdrive-") as folder:
                _put_model(table, Path(folder), header.model_file)
                return parse_arm_file(table, name=header.arm, folder=Path(folder))
        except (ArmError, KinematicsError, OSError) as error:
            raise RecordingError(f"the recording's arm file cannot be used: {error}") from None


def read_recording(path: Path) -> Recording:
    """Read a file. Raises `RecordingError`."""
    data = read_bytes(path, "the recording", RecordingError, most_bytes=MOST_FILE_BYTES)
    try:
        return parse_recording(data)
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from None


def parse_recording(data: bytes) -> Recording:
    """Turn a file's bytes into a recording. Raises `RecordingError`."""
    lines = io.BytesIO(data)  # line by line: a file of line breaks alone is refused at the second
    header = _header(_object(lines.readline().removesuffix(b"\n"), 1))
    entries = tuple(_entries(lines))
    return Recording(header, entries, cut_off=len(data) > 0 and not data.endswith(b"\n"))


def _put_model(table: dict[str, Any], folder: Path, text: str) -> None:
    """Have the arm file name the model file that came with it, and no other."""
    from armdrive.armfile import MODEL_FILE

    word = table.get("model")
    if isinstance(word, str) and word.lower().endswith(MODEL_FILE):
        (folder / f"model{MODEL_FILE}").write_text(text, encoding="utf-8", errors="replace")
        table["model"] = f"model{MODEL_FILE}"


def _object(line: bytes, number: int) -> Mapping[str, Any]:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"line {number} is no JSON: {error}") from None
    if not isinstance(found, dict):
        raise RecordingError(f"line {number} is no JSON object")
    return found


def _header(found: Mapping[str, Any]) -> Header:
    known = found.get(MARK)
    if known is None:
        raise RecordingError("it is no recording of a flight recorder")
    if known != FORMAT or isinstance(known, bool):
        raise RecordingError(f"it has format {known!r:.20}, and this armdrive reads {FORMAT}")
    names = [each.name for each in fields(Header)]
    if set(found) != {MARK, *names}:
        odd = min(set(found) ^ {MARK, *names})
        raise RecordingError(f"its first line has {odd!r:.40} too much or too few")
    values = {name: found[name] for name in names}
    values["began_s"] = _time_s(values["began_s"], 1)
    for name, value in values.items():
        if name != "began_s" and not isinstance(value, str):
            raise RecordingError(f"{name} in its first line must be text, not {value!r:.40}")
    return Header(**values)


def _entries(lines: Iterable[bytes]) -> Iterator[Entry]:
    """Yield an entry for each whole line; a last line that was cut off is left out."""
    latest_s = -math.inf
    for number, line in enumerate(lines, 2):
        if not line.endswith(b"\n"):
            return
        entry = _entry(_object(line, number), number)
        if entry.time_s < latest_s:
            raise RecordingError(f"line {number} is earlier than the line before it")
        latest_s = entry.time_s
        yield entry


def _entry(found: Mapping[str, Any], number: int) -> Entry:
    word = found.get("kind")
    kind = _KINDS.get(word) if isinstance(word, str) else None
    if kind is None:
        raise RecordingError(f"line {number} is of the unknown kind {word!r:.40}")
    key = "bytes" if kind in WIRE else "text"
    if set(found) != {"t", "kind", key}:
        raise RecordingError(f"line {number} must have t, kind and {key}, and nothing else")
    time_s, what = _time_s(found["t"], number), found[key]
    if not isinstance(what, str):
        raise RecordingError(f"{key} in line {number} must be text, not {what!r:.40}")
    if key == "text":
        return Entry(time_s, kind, what)
    try:
        return Entry(time_s, kind, what.encode("latin-1"))
    except UnicodeEncodeError:
        raise RecordingError(f"line {number} has a character that is no byte") from None


def _time_s(value: Any, number: int) -> float:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    if not plain or not -LATEST_S <= value <= LATEST_S:  # NaN is not within either
        raise RecordingError(f"line {number} has no time, but {value!r:.40}")
    return float(value)
