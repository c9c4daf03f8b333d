"""What passes on the wire of a held arm, told to other programs as it comes, by its recorder.

Each message is `{"wire": [[time_s, "sent" or "heard", bytes in hexadecimal], ...], "missed": how
many entries were passed over, "now_s": the arm's clock}`, or `{}` where nothing has passed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from armdrive.trace.entries import WIRE, TraceEntry

MOST = 200
"""So many entries of the recorder are taken at once."""
BACK = 4000
"""Who has not read for longer than so many passes over the oldest of them."""
PIECE_BYTES = 1024
"""Longer bytes are told in pieces: callers take messages of a bounded size."""
MESSAGE_BYTES = 8192

Piece = tuple[float, str, str]
Since = Callable[[int, int, int], tuple[int, tuple[TraceEntry, ...]]]
"""Returns entries of the recorder, as `EntryRing.since` does."""


def overheard(
    since: Since, now_s: Callable[[], float], closed: Callable[[], bool], every_s: float
) -> Iterator[dict[str, Any]]:
    """Give what passes from now on, looked at so often, until the arm has been closed."""
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
    """Put pieces together, as many as a message may have; one alone is never too long."""
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
