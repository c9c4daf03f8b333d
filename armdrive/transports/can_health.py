"""What is known of a CAN bus: what its error frames and its adapter's status say, in words.

Error frames are those of Linux (linux/can/error.h): their id is a set of classes, their data says
more. The status byte is Lawicel's answer to `F`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

ADVICE = (
    "check that the drives have power, that the cable's two ends have a resistor of 120 ohm each, "
    "and that all have one bit rate"
)


class BusState(Enum):
    """How well the adapter's own controller gets on with the bus."""

    ACTIVE = "active"
    WARNING = "warning"
    """It has seen so many errors that it says so."""
    PASSIVE = "error-passive"
    """It no longer interrupts others for errors: nobody acknowledges, or most frames are broken."""
    OFF = "bus-off"
    """It has left the bus: nothing is sent or heard any more."""


@dataclass(frozen=True, slots=True)
class BusHealth:
    """What was seen on a bus since it was opened."""

    state: BusState = BusState.ACTIVE
    sent: int = 0
    heard: int = 0
    error_frames: int = 0
    refused: int = 0
    """Frames that the adapter said it could not send."""
    read_errors: int = 0
    overrun: int = 0
    """Frames that came faster than they were taken, and were dropped, the oldest first."""
    forgotten: int = 0
    """Frames that were not sent, since this program had been suspended before they could be."""
    last_trouble: str = ""


_CLASSES = (
    (0x001, "a frame was not sent in time"),
    (0x002, "arbitration was lost"),
    (0x008, "the bus has a protocol error"),
    (0x010, "the transceiver reports trouble"),
    (0x020, "nobody acknowledged a frame"),
    (0x080, "the bus has an error"),
    (0x100, "the controller was restarted"),
)
_CONTROLLER, _BUS_OFF, _RESTARTED, _NO_ACK = 0x004, 0x040, 0x100, 0x020
_FULL, _WARNING, _PASSIVE, _AGAIN = 0x03, 0x0C, 0x30, 0x40
"""Of the second data byte of a controller's error frame."""


def of_error_frame(can_id: int, data: bytes) -> tuple[BusState | None, str]:
    """Return the state that an error frame tells, if it tells one, and what it says."""
    if can_id & _BUS_OFF:
        return BusState.OFF, "the controller is bus-off"
    detail = data[1] if can_id & _CONTROLLER and len(data) > 1 else 0
    if detail & _PASSIVE or can_id & _NO_ACK:
        why = "nobody acknowledged a frame" if can_id & _NO_ACK else "it is error-passive"
        return BusState.PASSIVE, why
    if detail & _WARNING:
        return BusState.WARNING, "it has reached its error warning limit"
    if can_id & _RESTARTED or detail & _AGAIN:
        return BusState.ACTIVE, "the controller is error-active again"
    if detail & _FULL:
        return None, "the adapter's buffer ran over"
    words = [text for bit, text in _CLASSES if can_id & bit]
    return None, ", ".join(words) or "an error frame without a reason"


_STATUS = (
    (0x01, "its receive buffer is full"),
    (0x02, "its transmit buffer is full"),
    (0x04, "it has reached its error warning limit"),
    (0x08, "its receive buffer ran over"),
    (0x20, "it is error-passive"),
    (0x40, "it lost arbitration"),
    (0x80, "it sees bus errors"),
)
TROUBLED = 0x20 | 0x80
_STATUS_WARNING = 0x04


def of_status(status: int) -> tuple[BusState, str]:
    """Return the state that an slcan adapter's status means, and what it says.

    Its protocol has no word for bus-off: error-passive with bus errors is the nearest.
    """
    words = ", ".join(text for bit, text in _STATUS if status & bit)
    if status & TROUBLED == TROUBLED:
        return BusState.OFF, words
    if status & TROUBLED:
        return BusState.PASSIVE, words
    return (BusState.WARNING if status & _STATUS_WARNING else BusState.ACTIVE), words


def left_bus(why: str) -> str:
    """Say that the adapter is bus-off."""
    return f"the adapter has left the bus ({why}): {ADVICE}"


def not_heard(why: str) -> str:
    """Say that nobody takes what is sent."""
    return f"nobody on the bus takes what is sent ({why}): {ADVICE}"
