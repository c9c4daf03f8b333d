"""The engine, its clocks, and the state of one arm: position, trust, record, stop bounds.

Which file decides what:

    states       the state machine; how evidence and alerts change trust; what a trust allows
    arm_state    the state of one arm, changed here only; faults, notices, the status
    position     commanded, acknowledged and read back; registers, offset, coordinates
    backlash     where each motor is within its lost motion, and how much it turns more
    persistence  when the position record is written, and the mark of a motion
    overrides    pause and speed override: their bounds, and how long a pause lasts
    stop_bounds  how long and how far an arm moves on after a stop
    engine       one task and one exchange at a time; a stop goes first; limits of waiting calls
    clock        real and simulated time; how long a round lasts before it counts as suspended
"""
