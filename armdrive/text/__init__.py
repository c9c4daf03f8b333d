"""Strict reading and writing of text: TOML, JSON, and what a person types."""
