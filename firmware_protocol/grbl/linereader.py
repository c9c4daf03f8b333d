"""Bytes into lines as GRBL's main loop does it: spaces and comments away, letters made capital.

A slash is dropped too, but in the `$` lines of FluidNC, whose settings have names with slashes.
Source: gnea/grbl grbl/protocol.c. CR and LF each end a line, and an empty line is a line.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from firmware_protocol.grbl.dialect import GRBL, Dialect, Variant

MAX_WAITING = 256
"""How many lines wait to be fetched."""

_CR, _LF, _SPACE = 0x0D, 0x0A, 0x20


@dataclass(frozen=True, slots=True)
class Unusable:
    """A line that cannot be executed whole: how it began, and why. It is answered with error 11."""

    start: str
    reason: str


class LineReader:
    """Lines out of bytes that hold no real-time commands, whatever the chunks they come in.

    Of a line that is too long no more than `max_line` characters are held. At most `MAX_WAITING`
    lines wait: in a flood the last of them is `Unusable`, and what comes after it is lost until
    lines are fetched. A simulated ring can feed byte by byte and look for a line after each.
    """

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self._max_line = dialect.max_line
        self._has_paths = dialect.variant is Variant.FLUIDNC
        self._each_end_counts = dialect.crlf_answers_twice
        self._waiting: deque[str | Unusable] = deque()
        self.discard()

    @property
    def partial(self) -> str:
        """The beginning of a line whose end has not come yet."""
        return self._kept.decode("latin-1")

    @property
    def buffered(self) -> int:
        """How many characters are held."""
        held = sum(len(e.start if isinstance(e, Unusable) else e) for e in self._waiting)
        return held + len(self._kept)

    def feed(self, data: bytes) -> None:
        """Take bytes, in any portions."""
        for byte in data:
            if byte in (_CR, _LF):
                self._end(byte)
            else:
                self._after_cr = False
                self._keep(byte)

    def next_line(self) -> str | Unusable | None:
        """Return the next line as GRBL stores it, or None when there is none."""
        return self._waiting.popleft() if self._waiting else None

    def discard(self) -> None:
        """Forget everything held, as a reset does; the next byte begins a new line."""
        self._waiting.clear()
        self._after_cr = False
        self._begin()

    @property
    def _in_path(self) -> bool:
        """Tell whether a slash belongs to the name of a setting, as of `$/stepping/idle_ms`."""
        return self._has_paths and self._kept.startswith(b"$")

    def _begin(self) -> None:
        self._kept = bytearray()
        self._comment = b""
        self._too_long = False

    def _keep(self, byte: int) -> None:
        sign = bytes((byte,))
        if self._too_long:
            return
        if self._comment:
            if self._comment == b"(" and sign == b")":
                self._comment = b""
        elif sign in (b"(", b";"):
            self._comment = sign
        elif byte > _SPACE and (sign != b"/" or self._in_path):
            self._too_long = len(self._kept) >= self._max_line
            self._kept += b"" if self._too_long else sign.upper()

    def _end(self, byte: int) -> None:
        second_half = byte == _LF and self._after_cr and not self._each_end_counts
        self._after_cr = byte == _CR
        if second_half:
            return
        text = self.partial
        reason = f"a line of more than {self._max_line} characters"
        self._put(Unusable(text, reason) if self._too_long else text)
        self._begin()

    def _put(self, entry: str | Unusable) -> None:
        room = MAX_WAITING - len(self._waiting)
        if room > 1:
            self._waiting.append(entry)
        elif room == 1:
            start = entry.start if isinstance(entry, Unusable) else entry
            reason = f"{MAX_WAITING} lines were waiting: from here on they are lost"
            self._waiting.append(Unusable(start, reason))


def clean_line(text: str) -> str:
    """Return one line of ASCII as GRBL stores it."""
    reader = LineReader(Dialect(max_line=max(1, min(len(text), 1024))))
    reader.feed(text.encode("ascii"))
    return reader.partial
