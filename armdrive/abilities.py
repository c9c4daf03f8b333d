"""What a dialect's device can do, as one value: the driver chooses its strategy from it alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from armdrive.budget import Traffic


class Abort(Enum):
    """How a motion that has begun can be ended from the host."""

    NONE = "a motion runs to its end: its length is the stopping distance"
    RAMP = "the device ramps down when asked"


class Switching(Enum):
    """What the host can do to the motor current."""

    NONE = "motors are always on"
    DROPS = "the host can switch the current off; the next motion brings it back"
    BOTH = "the host switches the current on and off"


@dataclass(frozen=True, slots=True)
class Abilities:
    """A row of the table of dialects (dialects.py).

    `jog_burst_s` and `planned_burst_s` are the longest motion sent at once, by default; an arm
    file accepts longer planned bursts with `motion.planned_burst_s`. `traffic` is what one of them
    puts on the wire (budget.py). `register_bits` is the width at which position registers wrap;
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
