"""The health of a CAN bus: error frames and adapter status in words, and frame lengths in bits.

Error frames are those of Linux (linux/can/error.h): the id is a set of error classes, and the data
gives details. The status byte is the answer to `F` in Lawicel's protocol.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from functools import cache, lru_cache

from firmware_protocol.frames import Frame

ADVICE = (
    "check that the drives have power, that the cable's two ends have a resistor of 120 ohm each, "
    "and that all have one bit rate"
)


class BusState(Enum):
    """The error state of the adapter's CAN controller."""

    ACTIVE = "active"
    WARNING = "warning"
    """An error counter has reached the warning limit."""
    PASSIVE = "error-passive"
    """The adapter no longer signals errors: frames go unacknowledged, or most are corrupt."""
    OFF = "bus-off"
    """The adapter has left the bus: it neither sends nor receives."""


@dataclass(frozen=True, slots=True)
class BusHealth:
    """The state and the counters of a bus since it was opened."""

    state: BusState = BusState.ACTIVE
    sent: int = 0
    heard: int = 0
    error_frames: int = 0
    refused: int = 0
    """Frames that the adapter reported as not sent."""
    read_errors: int = 0
    overrun: int = 0
    """Received frames that were dropped, oldest first, because they were not read in time."""
    forgotten: int = 0
    """Frames that were too old to send, for instance after this program was suspended."""
    last_trouble: str = ""


_CLASSES = (
    (0x001, "a frame was not sent in time"),
    (0x002, "arbitration was lost"),
    (0x008, "the bus has a protocol error"),
    (0x010, "the transceiver reports a fault"),
    (0x020, "no node acknowledged a frame"),
    (0x080, "the bus has an error"),
    (0x100, "the controller was restarted"),
)
_CONTROLLER, _BUS_OFF, _RESTARTED, _NO_ACK = 0x004, 0x040, 0x100, 0x020
_OVERFLOW, _WARNING, _PASSIVE, _ACTIVE_AGAIN = 0x03, 0x0C, 0x30, 0x40
"""Bits in the second data byte of an error frame of the class `_CONTROLLER`."""


def of_error_frame(can_id: int, data: bytes) -> tuple[BusState | None, str]:
    """Return the state that an error frame reports, if any, and its meaning in words."""
    if can_id & _BUS_OFF:
        return BusState.OFF, "the controller is bus-off"
    detail = data[1] if can_id & _CONTROLLER and len(data) > 1 else 0
    if detail & _PASSIVE or can_id & _NO_ACK:
        why = "no node acknowledged a frame" if can_id & _NO_ACK else "it is error-passive"
        return BusState.PASSIVE, why
    if detail & _WARNING:
        return BusState.WARNING, "it has reached its error warning limit"
    if can_id & _RESTARTED or detail & _ACTIVE_AGAIN:
        return BusState.ACTIVE, "the controller is error-active again"
    if detail & _OVERFLOW:
        return None, "the adapter's buffer overflowed"
    words = [text for bit, text in _CLASSES if can_id & bit]
    return None, ", ".join(words) or "an error frame without a reason"


_STATUS = (
    (0x01, "its receive buffer is full"),
    (0x02, "its transmit buffer is full"),
    (0x04, "it has reached its error warning limit"),
    (0x08, "its receive buffer overflowed"),
    (0x20, "it is error-passive"),
    (0x40, "it lost arbitration"),
    (0x80, "it sees bus errors"),
)
TROUBLED = 0x20 | 0x80  # error-passive, and bus errors
_STATUS_WARNING = 0x04


def of_status(status: int) -> tuple[BusState, str]:
    """Return the state that an slcan adapter's status byte means, and its meaning in words.

    The protocol has no bit for bus-off; error-passive together with bus errors is the closest.
    """
    words = ", ".join(text for bit, text in _STATUS if status & bit)
    if status & TROUBLED == TROUBLED:
        return BusState.OFF, words
    if status & TROUBLED:
        return BusState.PASSIVE, words
    return (BusState.WARNING if status & _STATUS_WARNING else BusState.ACTIVE), words


def left_bus(why: str) -> str:
    """Return the message for an adapter that is bus-off."""
    return f"the adapter has left the bus ({why}): {ADVICE}"


def not_heard(why: str) -> str:
    """Return the message for frames that no node on the bus receives."""
    return f"no node on the bus receives what is sent ({why}): {ADVICE}"


# --- The length of a classic CAN frame in bits, stuff bits included ------------------------------
#
# ISO 11898-1, 10.4 and 10.5: after five equal bits a bit of the opposite value is inserted, from
# the start of the frame to the end of its check sequence, a CRC of 15 bits with the polynomial 4599
# (hex).

BITS = 47  # a frame with an 11-bit id and no data, including the 3 idle bits after it
EXTENDED_BITS = 67  # the same with a 29-bit id
_POLYNOMIAL = 0x4599
_CRC_BITS = 15
_CRC_MASK = (1 << _CRC_BITS) - 1
_RUN = 5  # equal bits, after which one is stuffed

BUSY_LOAD = 0.7
"""The share of a bus that its traffic may take: beyond it, nodes wait for their turn."""


@lru_cache(maxsize=4096)
def frame_bits(frame: Frame) -> int:
    """Return a frame's length in bits, including stuff bits and the idle bits after it."""
    plain = (EXTENDED_BITS if frame.extended else BITS) + 8 * len(frame.data)
    bits, count = _fields(frame)
    crc = _crc(bits, count)
    return plain + _stuff_bits(bits << _CRC_BITS | crc, count + _CRC_BITS)


def _fields(frame: Frame) -> tuple[int, int]:
    """Return the bits from the start of the frame to the end of its data, and their number."""
    remote, data = int(frame.remote), frame.data
    if frame.extended:  # SOF, 11 id bits, SRR, IDE, 18 id bits, RTR, r1, r0
        head = (frame.can_id >> 18) << 2 | 0b11
        head = (head << 18 | frame.can_id & 0x3FFFF) << 3 | remote << 2
        count = 35
    else:  # SOF, 11 id bits, RTR, IDE, r0
        head, count = frame.can_id << 3 | remote << 2, 15
    bits = (head << 4 | len(data)) << 8 * len(data) | int.from_bytes(data, "big")
    return bits, count + 4 + 8 * len(data)


def _crc(bits: int, count: int) -> int:
    crc, by_byte = 0, _crc_table()
    for byte in bits.to_bytes(-(-count // 8), "big"):  # zeros before the first bit change nothing
        crc = crc << 8 & _CRC_MASK ^ by_byte[crc >> _CRC_BITS - 8 ^ byte]
    return crc


@cache
def _crc_table() -> tuple[int, ...]:
    """Return each byte's contribution to the CRC: of the byte xor the CRC's top eight bits."""
    table = []
    for upper in range(256):
        crc = upper << _CRC_BITS - 8
        for _ in range(8):
            crc = crc << 1 ^ _POLYNOMIAL * (crc >> _CRC_BITS - 1 & 1)
        table.append(crc & _CRC_MASK)
    return tuple(table)


_STUFFED_RUNS = re.compile("00000(?:11110000)*(?:1111)?|11111(?:00001111)*(?:0000)?")
"""Five equal bits, then each time four of the other value: with the stuff bit these are five."""


def _stuff_bits(bits: int, count: int) -> int:
    runs = _STUFFED_RUNS.findall(f"{bits:0{count}b}")
    return sum([(len(run) - 1) // (_RUN - 1) for run in runs])
