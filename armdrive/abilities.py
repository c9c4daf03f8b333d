"""The abilities of a dialect's device. The driver chooses its strategy from these values alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

# Whether an arm is held up or sags: after `disable`, `estop`, a power loss, or a closed port.

HELD, SAGS = "is held", "sags"  # each text of a `Torque` starts with one of these


@dataclass(frozen=True, slots=True)
class Torque:
    """What happens to the motors' holding torque, as the end of a sentence for each event.

    `closed_port` also describes the end of the program, its crash, and a pulled cable, once the
    last burst has ended.
    """

    disable: str
    estop: str
    power_loss: str
    closed_port: str

    @property
    def disable_warning(self) -> str:
        """The line that is shown before the motors are switched off."""
        return f"after `disable`, the arm {self.disable}"


# The length of bursts and segments: a compromise between the wire's rate and the stopping time.
#
# A motion is sent in pieces.
#
# *Short pieces stop soon.* A device drives what it has received to the end, or at best ramps down.
# The length of the pieces sent so far therefore **is** the stopping time. It never exceeds
# `PATIENCE_S`, however slow the wire is.
#
# *Long pieces move smoothly.* A device without a queue stands still while the next line is on the
# wire. At 10 bits per character, 9600 baud carry 960 characters a second, so a TeachMover's line of
# 36 characters and its reply of 2 take 40 ms. With bursts of 150 ms the arm moves for 79 % of the
# time. At the 2400 baud of an old cable the exchange takes four times as long. To move for the same
# share of the time, bursts would have to last 600 ms, which is too long for a stop: `PATIENCE_S`
# limits them, and the arm stutters.
#
# *A queue must not run empty.* A device that queues lines keeps moving while the next ones are on
# the wire. It receives `ahead_s` of motion in advance, in `SEGMENTS_AHEAD` pieces: it slows down
# before the last piece it knows, and with three pieces that one is always far enough away. Each
# piece has to last `HEADROOM` times longer than its line takes on the wire, or the queue runs
# empty. At 115200 baud a line of 34 characters and its ok take 3 ms, so pieces of 50 ms are long
# enough; at 9600 baud the same line takes 40 ms, and pieces have to last 80 ms.
#
# The table of dialects has a `Traffic` for each dialect, measured on moves of all motors. The
# lengths below guarantee nothing: stop_bounds.py computes the guaranteed stopping times from them.

BITS_A_BYTE = 10  # on a serial wire: a start bit, eight data bits and a stop bit
PATIENCE_S = 0.5  # longest burst on a slow wire, because a burst's length is the stopping time
SEGMENTS_AHEAD = 3  # also how many a driver fetches whose drives hold only their last order
RAMP_PIECE_S = 0.04  # length of the pieces that follow a queued motion's acceleration ramp
HEADROOM = 2.0  # least ratio of a segment's duration to its line's time on the wire


@dataclass(frozen=True, slots=True)
class Traffic:
    """The size of one piece of motion on the wire: its line and the reply, in characters.

    `device_s` is the device's own delay, for example of an interface that pauses after each
    character.
    """

    line_chars: int
    answer_chars: int
    device_s: float = 0.0

    def exchange_s(self, baud: int) -> float:
        """Return the duration of a line, the device's delay and the reply, one after another."""
        chars = self.line_chars + self.answer_chars
        return chars * BITS_A_BYTE / baud + self.device_s

    def line_s(self, baud: int) -> float:
        """Return the duration of a line alone; replies use the other direction of the wire."""
        return self.line_chars * BITS_A_BYTE / baud

    def shortest_segment_s(self, baud: int) -> float:
        """Return the least duration of a queued segment for the next one to arrive in time."""
        return HEADROOM * self.line_s(baud)


@dataclass(frozen=True, slots=True)
class Budget:
    """The lengths of bursts for a dialect on a particular wire."""

    jog_burst_s: float
    planned_burst_s: float


def budget(
    traffic: Traffic,
    baud: int,
    *,
    usual_baud: int,
    jog_burst_s: float,
    planned_burst_s: float,
    queued: int,
) -> Budget:
    """Return the lengths of bursts on this wire: the usual ones, or longer ones on a slow wire."""
    if queued:
        least_s = min(SEGMENTS_AHEAD * traffic.shortest_segment_s(baud), PATIENCE_S)
        return Budget(max(jog_burst_s, least_s), max(planned_burst_s, least_s))
    slower = max(traffic.exchange_s(baud) / traffic.exchange_s(usual_baud), 1.0)
    return Budget(_longer(jog_burst_s, slower), _longer(planned_burst_s, slower))


def _longer(burst_s: float, slower: float) -> float:
    """Return a burst's length on a slower wire, limited to `PATIENCE_S`."""
    return max(burst_s, min(burst_s * slower, PATIENCE_S))


def ramp_piece_s(ahead_s: float, shortest_s: float) -> float:
    """Return the length of a ramp's pieces: short enough to follow the ramp, if the wire can."""
    return min(segment_s(ahead_s), max(RAMP_PIECE_S, 2.0 * shortest_s))


def segment_s(ahead_s: float) -> float:
    """Return the length of a segment: the time sent ahead, divided into `SEGMENTS_AHEAD`."""
    return ahead_s / SEGMENTS_AHEAD


class Abort(Enum):
    """How the host can end a running motion."""

    NONE = "a motion runs to its end: its length is the stopping distance"
    RAMP = "the device ramps down when asked"


class Switching(Enum):
    """What the host can do to the motor current."""

    NONE = "motors are always on"
    DROPS = "the host can switch the current off; the next motion brings it back"
    BOTH = "the host switches the current on and off"


@dataclass(frozen=True, slots=True)
class Abilities:
    """The abilities that a dialect declares in its `ENTRY`.

    - `jog_burst_s`, `planned_burst_s`: the longest motion sent at once. An arm file can set longer
      planned bursts with `motion.planned_burst_s`. `traffic`: a burst's size on the wire.
    - `register_bits`: the width at which the position registers wrap.
    - `ramp_s`, `jerk_s`: the default ramps of planned motion.
    - `program_rows`: the most rows of a program that the device can store; 0 if it stores none.
    - `inputs`, `outputs`: the number of digital inputs that it reports, and of outputs it switches.
    - `encoders`: whether its registers are measured at the motors, so that a blocked one shows.
    - `beats`: whether the device sends heartbeats. Its line is then never quiet, but each of its
      replies names its request.
    - `order_s`: how long a prepared command stays valid; later, the device may have stopped by
      itself.
    """

    motors: int
    coordinated: bool
    abort: Abort
    current: Switching
    jog_burst_s: float
    planned_burst_s: float
    traffic: Traffic
    register_bits: int
    queued_segments: int = 0
    reports_while_moving: bool = False
    own_homing: bool = False
    resets_on_open: bool = False
    grip_switch: bool = False
    ramp_s: float = 0.0
    jerk_s: float = 0.0
    program_rows: int = 0
    inputs: int = 0
    outputs: int = 0
    encoders: bool = False
    beats: bool = False
    order_s: float = math.inf
