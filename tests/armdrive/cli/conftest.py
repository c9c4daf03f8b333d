"""A person's lines on the standard input."""

import io
import sys

import pytest
from cli_calls import typed


@pytest.fixture
def typing(monkeypatch):
    """Return a function that puts lines into the standard input, as a pipe does."""
    return lambda *lines: monkeypatch.setattr(sys, "stdin", io.StringIO(typed(*lines)))
