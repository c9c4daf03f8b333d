"""The health of a CAN bus: error frames and adapter status in words, and frame lengths in bits.

Error frames are those of Linux (linux/can/error.h): the id is a set of error classes, and the data
gives details. The status byte is the answer to `F` in Lawicel's protocol.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

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
    received: int = 0
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
# Bits in the second data byte of an error frame of the class `_CONTROLLER`.
_OVERFLOW, _WARNING, _PASSIVE, _ACTIVE_AGAIN = 0x03, 0x0C, 0x30, 0x40


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

BITS = 47  # a frame with an 11-bit id and no data, including the 3 idle bits after it
EXTENDED_BITS = 67  # the same with a 29-bit id
_UNSTUFFED_BITS = 13  # of these: the end of the frame, after its check sequence
_STUFF_EVERY = 4  # bits at most often: a stuff bit is the first of the next five equal bits

# The share of a bus that its traffic may take: beyond it, nodes wait for their turn.
BUSY_LOAD = 0.7


def frame_bits(frame: Frame) -> int:
    """Return a frame's greatest length in bits, including stuff bits and the idle bits after it.

    After five equal bits, from the start of the frame to the end of its check sequence, a bit of
    the opposite value is inserted (ISO 11898-1, 10.5). How many there are depends on the data; the
    greatest number is that of Davis, Burns, Bril and Lukkien, Controller Area Network
    Schedulability Analysis, 2007, section 2.
    """
    bits = (EXTENDED_BITS if frame.extended else BITS) + 8 * len(frame.data)
    return bits + (bits - _UNSTUFFED_BITS - 1) // _STUFF_EVERY
