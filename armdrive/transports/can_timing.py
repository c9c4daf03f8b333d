"""How long a classic CAN frame keeps the bus busy: its bits, stuff bits counted one by one.

ISO 11898-1, 10.4 and 10.5: after five bits alike one of the other value is put in, from the start
of the frame to the end of its check sequence; that is a CRC of 15 bits, its polynomial 4599 (hex).
"""

from __future__ import annotations

from functools import cache, lru_cache

from firmware_protocol.frames import Frame

BITS = 47
"""Of a frame with an 11-bit id and no data: its fields, and the 3 bits of silence after it."""
EXTENDED_BITS = 67
STUFFED = 34
"""As many of them are before the CRC's end, so that they can be stuffed; data bits all can."""
EXTENDED_STUFFED = 54
_POLYNOMIAL = 0x4599
_CRC_BITS = 15
_CRC_MASK = (1 << _CRC_BITS) - 1
_RUN = 5


@lru_cache(maxsize=4096)
def frame_bits(frame: Frame) -> int:
    """Return how many bits a frame takes, with its stuff bits and the silence after it."""
    plain = (EXTENDED_BITS if frame.extended else BITS) + 8 * len(frame.data)
    bits, count = _fields(frame)
    crc = _crc(bits, count)
    return plain + _stuff_bits(bits << _CRC_BITS | crc, count + _CRC_BITS)


def most_frame_bits(data_bytes: int, *, extended: bool = False) -> int:
    """Return the most that a frame of so many bytes can take, whatever is in it."""
    plain = (EXTENDED_BITS if extended else BITS) + 8 * data_bytes
    stuffed = (EXTENDED_STUFFED if extended else STUFFED) + 8 * data_bytes
    return plain + (stuffed - 1) // (_RUN - 1)


def _fields(frame: Frame) -> tuple[int, int]:
    """Return the bits from the start of the frame to the end of its data, and how many they are."""
    remote = int(frame.remote)
    if frame.extended:  # SOF, 11 id bits, SRR, IDE, 18 id bits, RTR, r1, r0
        head = (frame.can_id >> 18) << 2 | 0b11
        head = (head << 18 | frame.can_id & 0x3FFFF) << 3 | remote << 2
        count = 35
    else:  # SOF, 11 id bits, RTR, IDE, r0
        head, count = frame.can_id << 3 | remote << 2, 15
    bits = head << 4 | len(frame.data)
    for byte in frame.data:
        bits = bits << 8 | byte
    return bits, count + 4 + 8 * len(frame.data)


def _crc(bits: int, count: int) -> int:
    crc = 0
    for byte in bits.to_bytes(-(-count // 8), "big"):  # zeros before the first bit change nothing
        crc = crc << 8 & _CRC_MASK ^ _crc_of(crc >> _CRC_BITS - 8 ^ byte)
    return crc


@cache
def _crc_of(upper: int) -> int:
    """Return what eight bits make of a CRC whose upper eight have taken them in."""
    crc = upper << _CRC_BITS - 8
    for _ in range(8):
        crc = crc << 1 ^ _POLYNOMIAL * (crc >> _CRC_BITS - 1 & 1)
    return crc & _CRC_MASK


def _stuff_bits(bits: int, count: int) -> int:
    before = -count % 8  # filled with bits that alternate, the last one as on the idle bus
    filled = (0b0101_0101 & (1 << before) - 1) << count | bits
    stuffed, state = 0, (-1, 0)
    for byte in filled.to_bytes((count + before) // 8, "big"):
        more, state = _stuffed(state, byte)
        stuffed += more
    return stuffed


@cache
def _stuffed(state: tuple[int, int], byte: int) -> tuple[int, tuple[int, int]]:
    """Return how many bits are stuffed into eight, and the state behind them: a bit, its run."""
    stuffed, (last, run) = 0, state
    for place in range(7, -1, -1):
        bit = byte >> place & 1
        run = run + 1 if bit == last else 1
        last = bit
        if run == _RUN:  # the stuff bit begins a run of its own
            stuffed += 1
            run, last = 1, 1 - bit
    return stuffed, (last, run)
