"""robko01."""
