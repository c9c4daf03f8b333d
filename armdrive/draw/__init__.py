"""Drawing an arm with characters."""
