"""The numbers of GRBL's settings: `$110=500` sets the rate of the first axis.

Lengths are in the board's own unit, which it takes for mm. Source: gnea/grbl
doc/markdown/settings.md; from 40 to 99, grblHAL/core settings.h.
"""

IDLE_MS = 1
"""How long after a motion the motors keep their current, in ms."""
ALWAYS_ON_MS = 255
"""The value of `IDLE_MS` that leaves the motors on."""
REPORT = 10
"""The parts of a status report, one bit each."""
JUNCTION = 11
"""Junction deviation: how far a corner may be rounded."""
INCHES = 13
"""Whether reports are in inches."""
SOFT_LIMITS, HARD_LIMITS, HOMING = 20, 21, 22
HOMING_DIRECTIONS = 23
"""A bit for each axis that homes downwards."""
HOMING_FEED, HOMING_SEEK = 24, 25
"""The speeds at which homing approaches a switch and seeks it, per minute."""
DEBOUNCE_MS = 26
"""The pause of homing at a switch."""
PULL_OFF = 27
"""How far homing backs off a switch."""
MOST_SPEED, LEAST_SPEED, LASER = 30, 31, 32
"""The spindle's speeds in rpm, and whether it is a laser."""

HOMING_RUNS = 43
"""How often homing approaches a switch: grblHAL."""
SLEEP_ENABLE = 62
"""Whether `$SLP` is allowed: grblHAL."""

STEPS_PER_UNIT, RATE, ACCELERATION, TRAVEL = 100, 110, 120, 130
"""Of the first axis; add an axis's place on the board. Rates are per minute."""
