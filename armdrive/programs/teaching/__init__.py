"""Taught sequences: their steps, recording, stepping through them, shaping points, exporting."""
