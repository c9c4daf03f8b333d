"""The health of a CAN bus: error frames in words, and frame lengths in bits.

Error frames are those of Linux (linux/can/error.h): the id is a set of error classes, and the data
gives details.
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


# What error frames report: an error class, bits in the second data byte of the class 0x004, the
# state and its meaning. The first row that fits counts; other classes say nothing of the state.
_CONTROLLER = 0x004
_REPORTS = (
    (0x040, 0, BusState.OFF, "the controller is bus-off"),
    (0x020, 0, BusState.PASSIVE, "no node acknowledged a frame"),
    (_CONTROLLER, 0x30, BusState.PASSIVE, "it is error-passive"),
    (_CONTROLLER, 0x0C, BusState.WARNING, "it has reached its error warning limit"),
    (_CONTROLLER, 0x40, BusState.ACTIVE, "the controller is error-active again"),
    (0x100, 0, BusState.ACTIVE, "the controller was restarted"),
)


def of_error_frame(can_id: int, data: bytes) -> tuple[BusState, str] | None:
    """Return the state that an error frame reports, with its meaning in words; None for others."""
    detail = data[1] if len(data) > 1 else 0
    for error_class, bits, state, words in _REPORTS:
        if can_id & error_class and (not bits or detail & bits):
            return state, words
    return None


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
