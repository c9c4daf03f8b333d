"""Bytes from a terminal as what they mean: keys, and the terminal's answers to questions.

Nothing here reads a terminal or a clock: bytes and the time of their arrival come in.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

ASK_FOCUS = b"\x1b[?1004$p"
"""Asks whether focus events are known (DECRQM); the answer ends in a number of `_KNOWN`."""
ASK_RELEASES = b"\x1b[?u"
"""Asks whether key releases can be told (the kitty keyboard protocol); others stay silent."""
ASK_END = b"\x1b[c"
"""Every terminal answers this one: whatever has not been answered by then will not be."""

_FOCUS = re.compile(rb"\x1b\[\?1004;(\d)\$y")
_RELEASES = re.compile(rb"\x1b\[\?\d+u")
_END = re.compile(rb"\x1b\[\?[\d;]*c")
_KEY = re.compile(rb"\x1b\[[0-9;:?]*[ -/]*[@-~]|\x1bO[@-~]|\x1b(?=[^\[O])|[^\x1b]")
_KNOWN = {b"1", b"2", b"3"}
"""Set, reset, and set for good: a mode that the terminal knows."""


class Answer(Enum):
    """What a terminal can say of itself."""

    FOCUS = "it tells when its window gains or loses the focus"
    NO_FOCUS = "it does not tell when its window loses the focus"
    RELEASES = "it can tell when a key is let go"
    END = "it has answered everything that it will"


@dataclass(frozen=True, slots=True)
class Key:
    """A key event, as bytes, and when it arrived."""

    text: bytes
    time_s: float


class Arrivals:
    """Takes bytes apart; a sequence that is cut in two by a read is put together again."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes, now_s: float) -> list[Key | Answer]:
        """Return what these bytes complete, in order."""
        data, self._rest = self._rest + data, b""
        found: list[Key | Answer] = []
        place = 0
        while place < len(data):
            match = _KEY.match(data, place)
            if match is None:
                self._rest = data[place:]  # the rest of it has not arrived
                break
            place = match.end()
            found.append(_answer(match[0]) or Key(match[0], now_s))
        return found


def _answer(sequence: bytes) -> Answer | None:
    if focus := _FOCUS.fullmatch(sequence):
        return Answer.FOCUS if focus[1] in _KNOWN else Answer.NO_FOCUS
    if _RELEASES.fullmatch(sequence):
        return Answer.RELEASES
    return Answer.END if _END.fullmatch(sequence) else None
