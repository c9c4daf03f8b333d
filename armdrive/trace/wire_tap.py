"""The wire tap: the traffic of an arm, streamed to other programs while one program holds it.

Each message is `{"wire": [[time_s, direction, bytes in hexadecimal], ...], "missed": number of
skipped entries, "now_s": the arm's clock}`, or `{}` if there was no traffic. The direction is
`"sent"` for bytes to the arm and `"heard"` for bytes from it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from armdrive.trace.entries import WIRE, TraceEntry

MOST = 200  # entries fetched from the recorder at once
BACK = 4000  # a reader further behind than this skips the oldest entries
PIECE_BYTES = 1024  # longer entries are split, because messages have a bounded size
MESSAGE_BYTES = 8192

Piece = tuple[float, str, str]
Since = Callable[[int, int, int], tuple[int, tuple[TraceEntry, ...]]]
"""Returns entries of the recorder, as `EntryRing.since` does."""


def tap_messages(
    since: Since, now_s: Callable[[], float], closed: Callable[[], bool], every_s: float
) -> Iterator[dict[str, Any]]:
    """Yield the traffic from now on, polled every `every_s`, until the arm is closed."""
    number, _ = since(0, 0, 0)
    missed = 0
    while True:
        ended = closed()
        first, entries = since(number, MOST, BACK)
        missed, number = missed + first - number, first + len(entries)
        pieces = [piece for entry in entries if entry.kind in WIRE for piece in _pieces(entry)]
        for message in _messages(pieces):
            yield {"wire": message, "missed": missed, "now_s": now_s()}
            missed = 0
        if len(entries) == MOST:
            continue
        if ended:
            return
        if not pieces:
            yield {}
        time.sleep(every_s)


def _pieces(entry: TraceEntry) -> Iterator[Piece]:
    data = entry.what if isinstance(entry.what, bytes) else b""
    for at in range(0, len(data), PIECE_BYTES):
        yield entry.time_s, entry.kind.value, data[at : at + PIECE_BYTES].hex()


def _messages(pieces: list[Piece]) -> Iterator[list[Piece]]:
    """Group pieces into messages of at most `MESSAGE_BYTES`."""
    message: list[Piece] = []
    size = 0
    for piece in pieces:
        if message and size + len(piece[2]) > MESSAGE_BYTES:
            yield message
            message, size = [], 0
        message.append(piece)
        size += len(piece[2])
    if message:
        yield message
