"""gamepad."""
