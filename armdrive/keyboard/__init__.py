"""What this keyboard, terminal and link make of a key that is held: for `doctor --keyboard`."""
