"""What a dialect's device can do, as one value: the driver chooses its strategy from it alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

# Whether an arm is held or sags: after `disable`, `estop`, a loss of power, a closed port.

HELD, SAGS = "is held", "sags"
"""Every sentence of an arm begins with one of these."""


@dataclass(frozen=True, slots=True)
class Torque:
    """What becomes of the holding torque of one dialect's motors, a sentence for each event.

    `closed_port` is also what happens when this program ends or dies, or the cable is pulled, once
    the last burst has ended.
    """

    disable: str
    estop: str
    power_loss: str
    closed_port: str


# How long bursts and segments are: what the wire can carry, and what a person will wait for.
#
# A motion is sent in pieces, and the length of a piece is a bargain.
#
# *Short pieces stop soon.* What a device has been handed, it drives to the end, or at best ramps
# down. So the piece, or what is sent ahead of time, **is** the stopping time, and it stays below
# `PATIENCE_S` whatever the wire is like.
#
# *Long pieces move smoothly.* A device that queues nothing stands still while the next line is on
# its way: at 10 bits a character, 9600 baud carry 960 characters a second, so that a TeachMover's
# line of 36 characters and its answer of 2 take 40 ms. With bursts of 150 ms it is in motion for
# 79 % of the time. At the 2400 baud of an old cable the exchange takes four times as long; to be in
# motion for as much of the time, bursts would have to be four times as long as well, and 600 ms is
# more than anybody waits for a stop: `PATIENCE_S` is the end of it, and the arm stutters instead.
#
# *A queue needs something in it.* A device that queues lines drives on while the next ones are on
# the wire. It is kept `ahead_s` in advance, in `SEGMENTS_AHEAD` pieces: it slows down before the
# last piece that it knows of, and with three of them that one is always still far. Each piece has
# to last longer than its line takes on the wire, by `HEADROOM`, or the queue runs empty. At 115200
# baud a line of 34 characters and its ok take 3 ms, and pieces of 50 ms are driven from a queue
# that never does; at 9600 baud the same line takes 40 ms, and pieces shorter than 80 ms would.
#
# `Traffic` is what an exchange of a dialect puts on the wire, measured on moves of all motors; the
# table of dialects has one for each. Nothing here is a promise: the promise is that of
# stop_bounds.py, which is computed from the lengths that came out of this.

BITS_A_CHARACTER = 10
"""A start bit, eight of data and a stop bit."""

PATIENCE_S = 0.5
"""No wire is slow enough for a longer burst: it would be the stopping time."""

SEGMENTS_AHEAD = 3
RAMP_PIECE_S = 0.04
"""While a queued motion speeds up or slows down, pieces of this length follow its ramp."""

HEADROOM = 2.0
"""A segment lasts so many times longer than its line takes on the wire."""


@dataclass(frozen=True, slots=True)
class Traffic:
    """What one piece of motion puts on the wire: its line, and what comes back, in characters.

    `device_s` is what the device takes besides: an interface that pauses behind each character.
    """

    line_chars: int
    answer_chars: int
    device_s: float = 0.0

    def exchange_s(self, baud: int) -> float:
        """Return how long line and answer take, one after the other, and the device with them."""
        chars = self.line_chars + self.answer_chars
        return chars * BITS_A_CHARACTER / baud + self.device_s

    def line_s(self, baud: int) -> float:
        """Return how long a line takes by itself: answers come on the other wire."""
        return self.line_chars * BITS_A_CHARACTER / baud

    def shortest_segment_s(self, baud: int) -> float:
        """Return how long a queued segment has to last, so that the next one is there in time."""
        return HEADROOM * self.line_s(baud)


@dataclass(frozen=True, slots=True)
class Budget:
    """What a wire makes of the lengths that are usual for a dialect."""

    jog_burst_s: float
    planned_burst_s: float

    def moving_share(self, traffic: Traffic, baud: int, queued: int) -> float:
        """Return for which share of the time planned motion moves, as far as the wire is concerned.

        1 where the device drives on while lines are on their way.
        """
        if queued:
            return min(1.0, self.planned_burst_s / SEGMENTS_AHEAD / traffic.line_s(baud))
        return self.planned_burst_s / (self.planned_burst_s + traffic.exchange_s(baud))


def budget(
    traffic: Traffic,
    baud: int,
    *,
    usual_baud: int,
    jog_burst_s: float,
    planned_burst_s: float,
    queued: int,
) -> Budget:
    """Return how long bursts are on this wire: as usual, or longer where it is a slow one."""
    if queued:
        least_s = min(SEGMENTS_AHEAD * traffic.shortest_segment_s(baud), PATIENCE_S)
        return Budget(max(jog_burst_s, least_s), max(planned_burst_s, least_s))
    slower = max(traffic.exchange_s(baud) / traffic.exchange_s(usual_baud), 1.0)
    return Budget(_longer(jog_burst_s, slower), _longer(planned_burst_s, slower))


def _longer(burst_s: float, slower: float) -> float:
    """Return a burst that keeps its share of the time, within what a person waits for."""
    return max(burst_s, min(burst_s * slower, PATIENCE_S))


def ramp_piece_s(ahead_s: float, shortest_s: float) -> float:
    """Return how long a piece of a ramp is: short, so that it follows the ramp, if the wire can."""
    return min(segment_s(ahead_s), max(RAMP_PIECE_S, 2.0 * shortest_s))


def segment_s(ahead_s: float) -> float:
    """Return how long one of the segments is that make up the time sent ahead."""
    return ahead_s / SEGMENTS_AHEAD


class Abort(Enum):
    """How a motion that has begun can be ended from the host."""

    NONE = "a motion runs to its end: its length is the stopping distance"
    RAMP = "the device ramps down when asked"


class Switching(Enum):
    """What the host can do to the motor current."""

    NONE = "motors are always on"
    DROPS = "the host can switch the current off; the next motion brings it back"
    BOTH = "the host switches the current on and off"


OUTPUTS = 8
"""Outputs are numbered from 1 to this, on every arm that has any."""


@dataclass(frozen=True, slots=True)
class Abilities:
    """What a dialect states in its `ENTRY`.

    `jog_burst_s` and `planned_burst_s` are the longest motion sent at once, by default; an arm
    file accepts longer planned bursts with `motion.planned_burst_s`. `traffic` is what one of them
    puts on the wire. `register_bits` is the width at which position registers wrap;
    `ramp_s` and `jerk_s` are how gently planned motion begins and ends by default. `program_rows`
    is how many rows of a program of its own it can keep at most; 0: it keeps none. `inputs` is how
    many digital inputs it tells. `beats` says that it speaks unasked, again and again: its line is
    never quiet, and what it answers names its question. `order_s` is how long after it was thought
    out an order may still be said: later, the device may have stopped by itself.
    """

    motors: int
    coordinated: bool
    abort: Abort
    queued_segments: int
    speed_mode_with_watchdog: bool
    reports_while_moving: bool
    own_homing: bool
    resets_on_open: bool
    check_bytes: bool
    current: Switching
    grip_switch: bool
    pendant: bool
    jog_burst_s: float
    planned_burst_s: float
    traffic: Traffic
    register_bits: int
    ramp_s: float = 0.0
    jerk_s: float = 0.0
    program_rows: int = 0
    inputs: int = 0
    beats: bool = False
    order_s: float = math.inf
