"""A gamepad that jogs: its map, its device, and the hand on it."""
