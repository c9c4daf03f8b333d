"""The frames of the SUPER protocol: bytes to checked frames and back, in bounded memory.

    AA KIND LEN OP rest.. C0 C1      KIND 1 is a request, 2 an answer, whose rest begins with
                                     the status; LEN counts OP and the rest

C0 is the exclusive or of all bytes at even offsets, C1 of those at odd ones, the AA being at
offset 0. Source: robko01/fw_arduino_lib src/SUPER.cpp. The public program pyrobko01 counts the
two check bytes into LEN as well: `counts_check`.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import IntEnum

SENTINEL = 0xAA
PAYLOAD_MAX = 26
FRAME_MAX = 33
"""Bytes of the longest frame, an answer with a full payload. Requests end at 32."""
FLUSH = bytes((index // 2) ^ (index // 2 + 1) for index in range(FRAME_MAX))
"""Bytes that end whatever frame a reader believes to be in, the firmware's reader too.

It knows no silence: behind a spoilt length byte it swallows the next frames. Zeros would not do:
each check byte is the XOR of every other byte, so that a frame that lost two zeros, of which a
motion has many, would be made whole by two others, a word along from where it was. No beginning of
these bytes, in whole words, comes to zero, and none of them begins a frame; so a frame that lost
bytes becomes valid by chance alone: one time in 65536, or in 256 where only its last is missing.
"""

_HEADER = 3
_CHECK = 2
_RUN_MAX = 64
_WAITING_MAX = 256
_NO_FRAME = "no frame begins here"


class Kind(IntEnum):
    """Who speaks."""

    REQUEST = 1
    ANSWER = 2


_LENGTHS = {
    Kind.REQUEST: range(1, PAYLOAD_MAX + 2),
    Kind.ANSWER: range(2, PAYLOAD_MAX + 3),
}
"""What LEN can be: the operation, in answers the status, and the payload."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame whose check bytes fit. `start` counts the bytes that came before it."""

    raw: bytes
    start: int

    @property
    def kind(self) -> Kind:
        """Who sent it."""
        return Kind(self.raw[1])

    @property
    def op(self) -> int:
        """The operation's number, named or not."""
        return self.raw[_HEADER]

    @property
    def rest(self) -> bytes:
        """What stands between the operation and the check bytes."""
        return self.raw[_HEADER + 1 : -_CHECK]


@dataclass(frozen=True, slots=True)
class Noise:
    """Bytes in a row that belong to no frame, at most 64, and why."""

    data: bytes
    reason: str


def check_bytes(data: bytes | bytearray) -> bytes:
    """Return the two bytes that end a frame which begins with `data`."""
    even = odd = 0
    for byte in data[::2]:
        even ^= byte
    for byte in data[1::2]:
        odd ^= byte
    return bytes((even, odd))


def frame_bytes(kind: Kind, op: int, rest: bytes, *, counts_check: bool = False) -> bytes:
    """Return a whole frame."""
    length = 1 + len(rest) + (_CHECK if counts_check else 0)
    data = bytes((SENTINEL, kind, length, op)) + rest
    return data + check_bytes(data)


class FrameSplitter:
    """Frames out of bytes, whatever the chunks they come in.

    Where a frame turns out to be none, the search goes on at its second byte, so no good frame
    is lost behind bad bytes; it is seen at the latest when `FRAME_MAX` bytes have come after
    the bad ones, or at `silence`. Held are at most one unfinished frame, one run of noise and
    256 entries; when nobody fetches those, the oldest are lost and that is reported.
    """

    def __init__(self, *, counts_check: bool = False) -> None:
        self._counted = _CHECK if counts_check else 0
        self._pending = bytearray()
        self._run = bytearray()
        self._reason = _NO_FRAME
        self._waiting: deque[Frame | Noise] = deque()
        self._lost = 0
        self._consumed = 0

    @property
    def received(self) -> int:
        """How many bytes have come so far."""
        return self._consumed + len(self._pending)

    @property
    def buffered(self) -> int:
        """How many bytes are held."""
        waiting = sum(len(e.raw if isinstance(e, Frame) else e.data) for e in self._waiting)
        return waiting + len(self._run) + len(self._pending)

    def feed(self, data: bytes) -> None:
        """Take bytes, in any portions."""
        self._pending += data
        at = 0
        while at < len(self._pending) and (taken := self._take(at)):
            at += taken
        del self._pending[:at]
        self._consumed += at

    def silence(self) -> None:
        """Say that the frame which has begun will not be finished.

        What it has swallowed is searched for frames.
        """
        while self._pending:
            self._skip(self._pending[:1], "the frame was not finished")
            del self._pending[0]
            self._consumed += 1
            self.feed(b"")
        self._end_run()

    def next_frame(self) -> Frame | Noise | None:
        """Return the next frame, or bytes that are none, or None when there is nothing."""
        if self._lost:
            lost, self._lost = self._lost, 0
            return Noise(b"", f"{lost} frames or runs of noise were not fetched, and are lost")
        return self._waiting.popleft() if self._waiting else None

    def discard(self) -> None:
        """Forget every byte held: the next byte begins anew."""
        self._consumed += len(self._pending)
        for held in (self._pending, self._run, self._waiting):
            held.clear()
        self._lost = 0

    def _take(self, at: int) -> int:
        """Read what begins at an index; return how many bytes are done with, 0 for none yet."""
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
            self._put(Frame(frame, self._consumed + at))
            return size
        reason = f"the check bytes should be {wanted.hex(' ')}" if size else _NO_FRAME
        self._skip(pending[at : at + 1], reason)
        return 1

    def _size(self, at: int) -> int | None:
        """Return the length of the frame that begins at an index.

        None where its header is still coming in, 0 where it is the header of no frame.
        """
        header = self._pending[at : at + _HEADER]
        if len(header) > 1 and header[1] not in _LENGTHS:
            return 0
        if len(header) < _HEADER:
            return None
        length = header[2] - self._counted
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
            self._put(Noise(bytes(self._run), self._reason))
            self._run.clear()

    def _put(self, entry: Frame | Noise) -> None:
        if len(self._waiting) == _WAITING_MAX:
            self._waiting.popleft()
            self._lost += 1
        self._waiting.append(entry)


class Receiving:
    """What both ends of the protocol do with bytes that come in, as a stream or in datagrams."""

    def __init__(self, *, counts_check: bool) -> None:
        self._counts_check = counts_check
        self._frames = FrameSplitter(counts_check=counts_check)

    @property
    def buffered(self) -> int:
        """How many received bytes are held."""
        return self._frames.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the other end, in any portions."""
        self._frames.feed(data)

    def receive_datagram(self, data: bytes) -> None:
        """Take a datagram from the other end: no frame reaches from one into the next."""
        self._frames.silence()
        self._frames.feed(data)
        self._frames.silence()

    def silence(self) -> None:
        """Say that nothing has come for longer than a frame pauses.

        A frame that has begun is given up, and what it has swallowed is searched for others. A
        host calls it before `forget`; the firmware does nothing of the kind.
        """
        self._frames.silence()
