"""Checks every announced stop bound against the worst case of the simulated device."""
