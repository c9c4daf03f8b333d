"""The frame reader of a Robko 01's firmware, with its faults.

The codec's `Device` finds every good frame. The firmware's reader does not, and the driver has to
cope with it, so a simulated board reads its bytes as the firmware does (`SUPER.cpp`, read_frame).
"""

from __future__ import annotations

from collections.abc import Iterator

from firmware_protocol.robko01 import PAYLOAD_MAX, Op
from firmware_protocol.robko01.frames import SENTINEL, Kind, check_bytes, frame_bytes

LENGTHS = range(1, PAYLOAD_MAX + 2)
"""What the length byte can be: the operation and its payload."""
ECHOED = (Op.PING, Op.SET_ROBOT_ID, Op.GET_ROBOT_ID)
"""Operations whose payload has any length."""
PAYLOAD_BYTES = {
    Op.MOVE_RELATIVE: 24,
    Op.MOVE_ABSOLUTE: 24,
    Op.MOVE_SPEED: 24,
    Op.OUTPUTS: 1,
}
"""What an operation reads of the payload, whatever was sent; the others read nothing."""

_HEADER, _CHECK = 4, 2


class FirmwareReader:
    """Bytes in, whole requests out. All that it drops, it drops in silence.

    Two quirks, both seen on the ARDN_Operation example on an atmega328p in an AVR simulator:

    - **It loses the next frame** after a frame with a length of 0 and after a doubled 0xAA. A byte
      that does not fit sends it back to waiting for 0xAA without being looked at again, so an 0xAA
      among the bytes that are left over is taken for the beginning of a frame.
    - **Short payloads run on stale bytes.** The payload is copied into a buffer that nobody
      clears, and an operation reads its whole length from there. (What `MoveSpeed` finds behind a
      short payload was not seen; the same is assumed.) Bytes too many are ignored.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._frame = bytearray()
        self._payload = bytearray(PAYLOAD_MAX)
        self._skipping = False

    def read(self, data: bytes) -> Iterator[bytes]:
        """Yield each request that the firmware acts on, its payload as the operation reads it."""
        for byte in data:
            if not self._frame and byte != SENTINEL:
                self.dropped += not self._skipping
                self._skipping = True
                continue
            self._skipping = False
            self._frame.append(byte)
            if not self._fits():
                self._frame.clear()
                self.dropped += 1
            elif len(self._frame) > _HEADER and len(self._frame) == self._whole():
                frame = bytes(self._frame)
                self._frame.clear()
                if frame[-_CHECK:] != check_bytes(frame[:-_CHECK]):
                    self.dropped += 1
                elif frame[1] == Kind.REQUEST:
                    yield self._request(frame[_HEADER - 1], frame[_HEADER:-_CHECK])

    def _fits(self) -> bool:
        """Tell whether the last byte of the header can stand where it stands."""
        match len(self._frame):
            case 2:
                return self._frame[1] in (Kind.REQUEST, Kind.ANSWER)
            case 3:
                return self._frame[2] in LENGTHS
            case _:
                return True

    def _whole(self) -> int:
        return _HEADER - 1 + self._frame[2] + _CHECK

    def _request(self, op: int, payload: bytes) -> bytes:
        self._payload[: len(payload)] = payload
        if op not in ECHOED and op in tuple(Op):
            payload = bytes(self._payload[: PAYLOAD_BYTES.get(Op(op), 0)])
        return frame_bytes(Kind.REQUEST, op, payload)
