"""armdroid."""
