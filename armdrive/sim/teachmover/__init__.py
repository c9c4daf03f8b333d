"""teachmover."""
