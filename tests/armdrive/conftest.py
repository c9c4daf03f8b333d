"""Fixtures for several packages: calling commands, and writing programs."""

from __future__ import annotations

from textwrap import dedent

import pytest
from cli_calls import Caller


@pytest.fixture
def call(capsys):
    """Return a function that calls a command."""
    return Caller(capsys)


@pytest.fixture
def homed(call):
    """Return a function that calls a command on the referenced simulated arm."""
    call("home", code=0)
    return call


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a program, and returns its path for a command."""

    def written(text, name="t.arm"):
        path = tmp_path / name
        path.write_text(dedent(text), encoding="utf-8")
        return str(path)

    return written
