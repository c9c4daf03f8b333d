"""The driver against real firmware, in a processor simulator or on a real board."""
