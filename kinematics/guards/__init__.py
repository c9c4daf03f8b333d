"""Forbidden volumes: capsules, boxes, clearances, and proofs for a whole path."""
