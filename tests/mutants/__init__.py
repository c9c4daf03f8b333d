"""Deliberate faults, and the everyday tests that have to notice each."""
