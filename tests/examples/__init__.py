"""Examples run on the simulated arm of every dialect, and what is physically there afterwards."""
