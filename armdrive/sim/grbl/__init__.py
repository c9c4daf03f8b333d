"""grbl."""
