"""The numbers of GRBL's settings: `$110=500` sets the rate of the first axis.

Lengths are in the board's own unit, which it takes for mm. Source: gnea/grbl
doc/markdown/settings.md; from 40 to 99, grblHAL/core settings.h.
"""

# How long after a motion the motors keep their current, in ms.
IDLE_MS = 1
# The value of `IDLE_MS` that leaves the motors on.
ALWAYS_ON_MS = 255
# The parts of a status report, one bit each.
REPORT = 10
# Junction deviation: how far a corner may be rounded.
JUNCTION = 11
# Whether reports are in inches.
INCHES = 13
SOFT_LIMITS, HARD_LIMITS, HOMING = 20, 21, 22
# A bit for each axis that homes downwards.
HOMING_DIRECTIONS = 23
# The speeds at which homing approaches a switch and seeks it, per minute.
HOMING_FEED, HOMING_SEEK = 24, 25
# The pause of homing at a switch.
DEBOUNCE_MS = 26
# How far homing backs off a switch.
PULL_OFF = 27
# The spindle's speeds in rpm.
MOST_SPEED, LEAST_SPEED = 30, 31

# How often homing approaches a switch: grblHAL.
HOMING_RUNS = 43
# Whether `$SLP` is allowed: grblHAL.
SLEEP_ENABLE = 62

# Of the first axis; add an axis's place on the board. Rates are per minute.
STEPS_PER_UNIT, RATE, ACCELERATION, TRAVEL = 100, 110, 120, 130
