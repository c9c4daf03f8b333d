"""Vectors, rotations, orientations and transforms, and graphs of named frames."""
