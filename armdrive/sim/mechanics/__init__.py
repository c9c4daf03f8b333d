"""Motors in motion: speed profiles, queued lines, steppers, closed-loop shafts, limit switches."""
