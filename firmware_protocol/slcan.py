"""slcan, the text protocol of serial CAN adapters: frames as lines, for both ends.

This is Lawicel's ASCII protocol. `tIIILDD..` is a frame with an 11-bit id, `T` has 29 bits, and `r`
and `R` are remote frames. A line ends with CR. With a bell the adapter refuses a command.
"""

from __future__ import annotations

import re

from firmware_protocol.frames import Frame

CR = b"\r"
BELL = b"\a"
ON_BUS = b"tTrR"  # first letters of the lines that are frames
LONGEST = 256  # longer lines count as noise
_FRAME = re.compile(rb"(?:([tr])([0-7][0-9A-F]{2})|([TR])([01][0-9A-F]{7}))([0-8])([0-9A-F]*)")
_STAMP_DIGITS = 4  # an adapter may append a timestamp, which is ignored


class SlcanLines:
    """Splits bytes from a serial port into lines; a bell ends a line, as CR does."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the completed lines, without CR but with the bell."""
        *whole, rest = (self._rest + data.replace(BELL, BELL + CR)).split(CR)
        self._rest = rest[: LONGEST + 1]
        return [line for line in whole if len(line) <= LONGEST]


def line_of(frame: Frame) -> bytes:
    """Return a frame's line, with CR."""
    kind = "r" if frame.remote else "t"
    can_id = f"{frame.can_id:08X}" if frame.extended else f"{frame.can_id:03X}"
    kind = kind.upper() if frame.extended else kind
    return f"{kind}{can_id}{len(frame.data)}{frame.data.hex().upper()}\r".encode()


def frame_of(line: bytes) -> Frame | None:
    """Return the frame of a line without CR; None if the line is not a frame."""
    found = _FRAME.fullmatch(line[:1] + line[1:].upper())
    if found is None:
        return None
    kind = found[1] or found[3]
    remote, length = kind in b"rR", int(found[5])
    digits = 0 if remote else 2 * length
    if len(found[6]) not in (digits, digits + _STAMP_DIGITS):
        return None
    data = bytes.fromhex(found[6][:digits].decode())
    return Frame(int(found[2] or found[4], 16), data, extended=kind in b"TR", remote=remote)
