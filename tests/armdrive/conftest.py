"""What tests of several packages share: calling commands, and writing programs."""

from __future__ import annotations

from textwrap import dedent

import pytest
from cli_calls import Caller


@pytest.fixture
def call(capsys):
    """Call a command."""
    return Caller(capsys)


@pytest.fixture
def homed(call):
    """Call a command on the simulated arm, which has been referenced."""
    call("home", code=0)
    return call


@pytest.fixture
def write(tmp_path):
    """Write a program; return its path as a command takes it."""

    def written(text, name="t.arm"):
        path = tmp_path / name
        path.write_text(dedent(text), encoding="utf-8")
        return str(path)

    return written
