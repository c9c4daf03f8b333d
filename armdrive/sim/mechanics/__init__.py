"""Motors in motion: speed profiles, queued lines, steppers, closed-loop shafts, limit switches.

Which file decides what:

    profiles       one axis speeding up, running and slowing down
    planner        queued lines, and the speed at their corners
    accelstepper   steppers that turn independently, step by step
    motors         steppers that turn together, their true speed, and where a limit switch closes
    shafts         set-points in a closed loop, and the arm that follows them
"""
