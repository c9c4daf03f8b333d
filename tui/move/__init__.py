"""Planned motion: a goal is typed, seen, confirmed twice, and gone to."""
