"""Where a twin has to stand for a recording: the counts, offsets and gaps in its entries."""

from __future__ import annotations

import re
from collections.abc import Sequence

from armdrive.errors import RecordingError
from armdrive.recorder.entries import Entry, Kind

Counts = tuple[int, ...]

_POSITIONED = ("referenced", "restored")
_COUNTS = re.compile(r"(-?[0-9]{1,9}(?: -?[0-9]{1,9})*)(?:;|$)")
_NO_COUNTS = (Kind.REQUEST, Kind.SILENCE, Kind.REPLY, Kind.LOST)


def counts_of(entry: Entry) -> Counts:
    """Return the motors' counts that an entry begins with. Raises `RecordingError`."""
    found = _COUNTS.match(str(entry.what))
    if found is None:
        raise RecordingError(f"{entry.what!r:.60} stands where the counts of motors belong")
    return tuple(int(word) for word in found[1].split(" "))


def first_counts(entries: Sequence[Entry]) -> Counts | None:
    """Return what the controller told first."""
    return next((counts_of(entry) for entry in entries if entry.kind is Kind.REGISTERS), None)


def first_offset(entries: Sequence[Entry]) -> Counts | None:
    """Return what made counts a position when the position was first known."""
    offset = None
    for entry in entries:
        if entry.kind is Kind.OFFSET:
            offset = counts_of(entry)
        elif entry.kind is Kind.TRUST and str(entry.what).startswith(_POSITIONED):
            return offset
    return None


def offset_at(entries: Sequence[Entry], index: int) -> Counts | None:
    """Return the offset at an entry, None where the position was not known by then."""
    known = first_offset(entries[:index])
    found = (entry for entry in reversed(entries[:index]) if entry.kind is Kind.OFFSET)
    latest = next(found, None)
    return None if known is None or latest is None else counts_of(latest)


def position(counts: Counts, offset: Counts | None) -> Counts | None:
    """Return where the motors are, None where that is not known."""
    if offset is None or len(offset) != len(counts):
        return None
    return tuple(a + b for a, b in zip(counts, offset, strict=True))


def gap(entries: Sequence[Entry]) -> range:
    """Return which entries are not to be compared: from the first gap to where counts are read.

    There the twin can be put to where the arm stood. Empty where nothing is missing.
    """
    gaps = [index for index, entry in enumerate(entries) if entry.kind is Kind.GAP]
    if not gaps:
        return range(len(entries), len(entries))
    for index in range(gaps[-1], len(entries)):
        if answer_to(entries, index) is not None:
            return range(gaps[0], index)
    return range(gaps[0], len(entries))


def answer_to(entries: Sequence[Entry], index: int) -> Entry | None:
    """Return the counts that answer an entry, if it asks for them and gets them."""
    entry = entries[index]
    if entry.kind is not Kind.REQUEST or not str(entry.what).startswith("ReadPosition"):
        return None
    for later in range(index + 1, len(entries)):
        if entries[later].kind is Kind.REGISTERS:
            return entries[later]
        if entries[later].kind in _NO_COUNTS:
            return None
    return None
