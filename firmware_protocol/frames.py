"""CAN frames, and the records that carry them through byte links and recordings.

A record holds one frame:

    C5 KIND ID.. DATA.. CRC CRC     KIND: bits 3-0 length, 7 extended, 6 remote
                                    ID: 2 bytes, or 4 if extended, high byte first
                                    CRC: CRC-16 (CCITT, from FFFF) of all preceding bytes

Frames are classic CAN. Remote frames have no data, and their requested length is not stored.
"""

from __future__ import annotations

import re
from binascii import crc_hqx
from functools import lru_cache
from typing import NamedTuple

from firmware_protocol.errors import BadField, whole
from firmware_protocol.fields import boolean

STANDARD_ID_MAX, EXTENDED_ID_MAX = 0x7FF, 0x1FFF_FFFF
DATA_MAX = 8
RECORD_MAX = 16  # bytes in the longest record

_SYNC = 0xC5
_EXTENDED, _REMOTE, _UNUSED, _LENGTH = 0x80, 0x40, 0x30, 0x0F
_HEADER, _CRC = 2, 2
_CRC_BEGIN = 0xFFFF
_TEXT = r"([0-9A-F]{3}|[0-9A-F]{8})#(R[0-8]?|(?:[0-9A-F]{2}\.?){0,8})"


class _FrameFields(NamedTuple):
    can_id: int
    data: bytes = b""
    extended: bool = False
    remote: bool = False


class Frame(_FrameFields):
    """A classic CAN frame.

    A tuple, because a bus carries thousands a second, and tables of known frames need its hash.
    """

    __slots__ = ()

    def __new__(
        cls, can_id: int, data: bytes = b"", extended: bool = False, remote: bool = False
    ) -> Frame:
        """Make a frame. Raises `BadField` for invalid fields."""
        boolean("extended", extended)
        boolean("remote", remote)
        whole("can_id", can_id, 0, EXTENDED_ID_MAX if extended else STANDARD_ID_MAX)
        most = 0 if remote else DATA_MAX
        if not isinstance(data, bytes) or len(data) > most:
            raise BadField("data", data, f"at most {most} bytes")
        return super().__new__(cls, can_id, data, extended, remote)

    def __str__(self) -> str:
        """Format as candump does: `123#01F6`, eight digits if extended, `123#R` if remote."""
        number = f"{self.can_id:08X}" if self.extended else f"{self.can_id:03X}"
        return f"{number}#{'R' if self.remote else self.data.hex().upper()}"

    @classmethod
    def parse(cls, text: str) -> Frame:
        """Parse the format of `str`; also dots between bytes, and lower case. Raises `BadField`."""
        found = re.fullmatch(_TEXT, text, re.IGNORECASE)
        if found is None:
            raise BadField("frame", text, "three or eight hex digits, a #, and R or 0 to 8 bytes")
        number, rest = found.groups()
        remote = rest[:1] in ("R", "r")
        data = b"" if remote else bytes.fromhex(rest.replace(".", ""))
        return cls(int(number, 16), data, len(number) > 3, remote)


@lru_cache(maxsize=4096)
def pack(frame: Frame) -> bytes:
    """Return the record of a frame; cached, as each node that it passes packs it again."""
    kind = len(frame.data) | frame.extended * _EXTENDED | frame.remote * _REMOTE
    number = frame.can_id.to_bytes(4 if frame.extended else 2, "big")
    body = bytes((_SYNC, kind)) + number + frame.data
    return body + crc_hqx(body, _CRC_BEGIN).to_bytes(_CRC, "big")


class Unpacker:
    """Extracts frames from a stream of records in any chunks. Never raises.

    After an invalid record, the search goes on at its second byte, so that bad bytes never hide a
    good record. The buffer holds less than one record.
    """

    def __init__(self) -> None:
        self._pending = bytearray()

    def feed(self, data: bytes) -> list[Frame]:
        """Take bytes in any chunks; return the frames that they complete."""
        self._pending += data
        frames: list[Frame] = []
        at = 0
        while at < len(self._pending):
            size = _size(self._pending, at)
            if size is None or at + size > len(self._pending):
                break
            frame = _whole(bytes(self._pending[at : at + size])) if size else None
            if frame is None:  # not a record, or a damaged one, which may hide the start of another
                following = self._pending.find(_SYNC, at + 1)
                at = following if following > 0 else len(self._pending)
                continue
            frames.append(frame)
            at += size
        del self._pending[:at]
        return frames

    def silence(self) -> list[Frame]:
        """Abandon the incomplete record; return the frames found inside it."""
        frames: list[Frame] = []
        while self._pending:
            del self._pending[0]
            frames += self.feed(b"")
        return frames


def _size(pending: bytes | bytearray, at: int) -> int | None:
    """Return the length of the record at an index: None if not yet known, 0 if there is none."""
    if pending[at] != _SYNC:
        return 0
    if len(pending) < at + _HEADER:
        return None
    kind = pending[at + 1]
    length = kind & _LENGTH
    if kind & _UNUSED or length > (0 if kind & _REMOTE else DATA_MAX):
        return 0
    return _HEADER + (4 if kind & _EXTENDED else 2) + length + _CRC


@lru_cache(maxsize=4096)
def _whole(record: bytes) -> Frame | None:
    """Return the frame of one whole record, or None; cached, as all nodes of a bus read it."""
    if _size(record, 0) != len(record):
        return None
    body = record[:-_CRC]
    if crc_hqx(body, _CRC_BEGIN) != int.from_bytes(record[-_CRC:], "big"):
        return None
    extended = bool(body[1] & _EXTENDED)
    begins = _HEADER + (4 if extended else 2)
    number = int.from_bytes(body[_HEADER:begins], "big")
    try:
        return Frame(number, body[begins:], extended, bool(body[1] & _REMOTE))
    except BadField:
        return None


# slcan, Lawicel's text protocol of serial CAN adapters: frames as lines, for both ends.
#
# `tIIILDD..` is a frame with an 11-bit id, `T` has 29 bits, and `r` and `R` are remote frames. A
# line ends with CR. With a bell the adapter refuses a command.

CR = b"\r"
BELL = b"\a"
ON_BUS = b"tTrR"  # first letters of the lines that are frames
LONGEST_LINE = 256  # longer lines count as noise
_FRAME = re.compile(rb"(?:([tr])([0-7][0-9A-F]{2})|([TR])([01][0-9A-F]{7}))([0-8])([0-9A-F]*)")
_STAMP_DIGITS = 4  # an adapter may append a timestamp, which is ignored


class SlcanLines:
    """Splits bytes from a serial port into lines; a bell ends a line, as CR does."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the completed lines, without CR but with the bell."""
        *whole, rest = (self._rest + data.replace(BELL, BELL + CR)).split(CR)
        self._rest = rest[: LONGEST_LINE + 1]  # one byte more, so that a cut line still is too long
        return [line for line in whole if len(line) <= LONGEST_LINE]


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
