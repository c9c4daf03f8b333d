"""Programs: their lines on any screen, and the screen on which one is rehearsed and run."""
