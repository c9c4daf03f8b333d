"""The only room that opens a wire."""
