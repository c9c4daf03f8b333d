"""The desk: a terminal screen that jogs an arm."""
