"""Frames of the SUPER protocol: bytes to checked frames and back, in bounded memory.

    AA KIND LEN OP rest.. C0 C1      KIND 1 is a request, 2 an answer, whose rest begins with
                                     the status; LEN counts OP and the rest

C0 is the XOR of all bytes at even offsets, C1 of those at odd offsets; the AA is at offset 0.
Source: robko01/fw_arduino_lib src/SUPER.cpp.
"""

from __future__ import annotations

from collections import deque
from enum import IntEnum

from firmware_protocol.events import Unreadable
from firmware_protocol.fields import message

SENTINEL = 0xAA
PAYLOAD_MAX = 26
# Bytes in the longest frame, an answer with a full payload; a request has at most 32.
FRAME_MAX = 33
# Bytes that end any half-read frame, in this reader and in the firmware's.
#
# The firmware has no timeout: after a corrupt length byte it swallows the frames that follow. Zeros
# would be unsafe. Each check byte is the XOR of every other byte, so a frame that lost two zeros (a
# motion has many) would become valid with two other zeros, its data shifted by a word. No leading
# whole words of these bytes have an XOR of zero, and none of these bytes begins a frame. So a frame
# that lost bytes becomes valid only by chance: once in 65536, or once in 256 if only its last byte
# is missing.
FLUSH = bytes((index // 2) ^ (index // 2 + 1) for index in range(FRAME_MAX))

_HEADER = 3
_CHECK = 2
_RUN_MAX = 64
_NO_FRAME = "no frame begins here"


class Kind(IntEnum):
    """The kind of a frame, and so its sender."""

    REQUEST = 1
    ANSWER = 2


# Valid values of LEN: the operation, the status (in answers) and the payload.
_LENGTHS = {
    Kind.REQUEST: range(1, PAYLOAD_MAX + 2),
    Kind.ANSWER: range(2, PAYLOAD_MAX + 3),
}


@message()
class SuperFrame:
    """A frame with correct check bytes. `start` is the number of bytes received before it."""

    raw: bytes
    start: int

    @property
    def kind(self) -> Kind:
        """Request or answer."""
        return Kind(self.raw[1])

    @property
    def op(self) -> int:
        """The operation's number, known or unknown."""
        return self.raw[_HEADER]

    @property
    def rest(self) -> bytes:
        """The bytes between the operation and the check bytes."""
        return self.raw[_HEADER + 1 : -_CHECK]


def check_bytes(data: bytes | bytearray) -> bytes:
    """Return the two check bytes for a frame that begins with `data`."""
    even = odd = 0
    for byte in data[::2]:
        even ^= byte
    for byte in data[1::2]:
        odd ^= byte
    return bytes((even, odd))


def frame_bytes(kind: Kind, op: int, rest: bytes) -> bytes:
    """Return a complete frame."""
    data = bytes((SENTINEL, kind, 1 + len(rest), op)) + rest
    return data + check_bytes(data)


class FrameSplitter:
    """Extracts frames from bytes in any chunks.

    After an invalid frame, the search goes on at its second byte, so that bad bytes never hide a
    good frame; it is found at the latest `FRAME_MAX` bytes after the bad ones, or at `silence`. Bad
    bytes are reported in runs of at most 64. The caller also fetches what the bytes contain.
    """

    def __init__(self) -> None:
        self._pending = bytearray()
        self._run = bytearray()
        self._reason = _NO_FRAME
        self._waiting = deque[SuperFrame | Unreadable]()
        self._consumed = 0

    @property
    def received(self) -> int:
        """Number of bytes received so far."""
        return self._consumed + len(self._pending)

    def feed(self, data: bytes) -> None:
        """Take bytes in any chunks."""
        self._pending += data
        at = 0
        while at < len(self._pending) and (taken := self._take(at)):
            at += taken
        del self._pending[:at]
        self._consumed += at

    def silence(self) -> None:
        """Abandon the incomplete frame and search its bytes for other frames."""
        while self._pending:
            self._skip(self._pending[:1], "the frame was not finished")
            del self._pending[0]
            self._consumed += 1
            self.feed(b"")
        self._end_run()

    def next_frame(self) -> SuperFrame | Unreadable | None:
        """Return the next frame, the next run of bytes between frames, or None."""
        return self._waiting.popleft() if self._waiting else None

    def discard(self) -> None:
        """Discard all buffered bytes and entries."""
        self._consumed += len(self._pending)
        self._pending.clear()
        self._run.clear()
        self._waiting.clear()

    def _take(self, at: int) -> int:
        """Process the bytes at an index; return the number consumed, 0 if more are needed."""
        pending = self._pending
        begins = pending.find(SENTINEL, at)
        if begins != at:
            end = len(pending) if begins < 0 else begins
            self._skip(pending[at:end], _NO_FRAME)
            return end - at
        size = self._size(at)
        if size is None or at + size > len(pending):
            return 0
        frame = bytes(pending[at : at + size])
        wanted = check_bytes(frame[:-_CHECK])
        if size and frame[-_CHECK:] == wanted:
            self._end_run()
            self._waiting.append(SuperFrame(frame, self._consumed + at))
            return size
        reason = f"the check bytes should be {wanted.hex(' ')}" if size else _NO_FRAME
        self._skip(pending[at : at + 1], reason)
        return 1

    def _size(self, at: int) -> int | None:
        """Return the length of the frame at an index.

        None if the header is incomplete, 0 if it is not the header of a frame.
        """
        header = self._pending[at : at + _HEADER]
        if len(header) > 1 and header[1] not in _LENGTHS:
            return 0
        if len(header) < _HEADER:
            return None
        length = header[2]
        return _HEADER + length + _CHECK if length in _LENGTHS[Kind(header[1])] else 0

    def _skip(self, data: bytearray, reason: str) -> None:
        while data:
            if not self._run or reason is not _NO_FRAME:
                self._reason = reason
            room = _RUN_MAX - len(self._run)
            self._run += data[:room]
            data = data[room:]
            if len(self._run) == _RUN_MAX:
                self._end_run()

    def _end_run(self) -> None:
        if self._run:
            self._waiting.append(Unreadable(bytes(self._run), self._reason))
            self._run.clear()
