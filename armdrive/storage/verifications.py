"""What was found each time an arm was verified: a file of JSON lines in the state folder."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armdrive.storage import files as places
from armdrive.storage.files import DISK, append_line

if TYPE_CHECKING:
    from armdrive.motion.verify import Verified

LONGEST = 1_000_000
"""Bytes that are read of a log: some thousands of lines."""


def logbook_file(arm: str) -> Path:
    """Return the file in which an arm's verifications are kept."""
    return places.states() / f"{places.file_name(arm)}.verified.jsonl"


def verified_view(verified: Verified) -> dict[str, Any]:
    """Return a verification as plain data, with units in the names."""
    drift = verified.drift
    return {
        "verdict": verified.verdict.name.lower(),
        "steps": list(drift.steps),
        "joints_deg": {name: round(angle, 4) for name, angle in drift.turned.deg.items()},
        "opening_mm": round(drift.opening_mm, 3),
        "tip_mm": round(drift.tip_mm, 3),
        "accepted": verified.accepted,
        "note": verified.note,
    }


def write_down(path: Path, verified: Verified, calibration: str, reference: str) -> None:
    """Add a line with the date. Raises `OSError`."""
    line = {
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "calibration": calibration,
        "reference": reference,
        **verified_view(verified),
    }
    append_line(path, json.dumps(line))


def last_entry(path: Path, calibration: str) -> dict[str, Any] | None:
    """Return the last entry of the same calibration; damaged lines are passed over."""
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
