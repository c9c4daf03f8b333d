"""The log of an arm's verifications: a file of JSON lines in the state folder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from armdrive.storage import files as places
from armdrive.storage.files import DISK, append_line

LONGEST = 1_000_000  # bytes read from the end of a log: some thousands of lines


def logbook_file(arm: str) -> Path:
    """Return the file of an arm's verifications."""
    return places.states() / f"{places.file_name(arm)}.verified.jsonl"


def write_down(path: Path, view: Mapping[str, Any], calibration: str, reference: str) -> None:
    """Append a verification with the date; `view` is its plain data. Raises `OSError`."""
    line = {
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "calibration": calibration,
        "reference": reference,
        **view,
    }
    append_line(path, json.dumps(line))


def last_entry(path: Path, calibration: str) -> dict[str, Any] | None:
    """Return the latest entry with this calibration, or None; damaged lines are skipped."""
    try:
        lines = DISK.read_own(path, LONGEST, end=True).splitlines()
    except OSError:
        return None
    for line in reversed(lines):
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(entry, dict) and entry.get("calibration") == calibration:
            return entry
    return None
