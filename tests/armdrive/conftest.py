"""Fixtures for several packages: calling commands, writing programs, holding a simulated arm."""

from textwrap import dedent

import pytest
from cli_calls import Caller

from armdrive import Arm
from armdrive.connect.control_socket import serve
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.storage.arm_lock import hold


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


@pytest.fixture
def arm():
    """Return a simulated arm."""
    with Arm(connect_simulated(simulated_config("teachmover"))) as arm:
        yield arm


@pytest.fixture
def holding(arm):
    """Hold the arm by its name and by that of its port, and serve it to other programs."""
    holding = hold("bench", "/dev/ttyUSB0")
    serve(holding, arm.parts.connection)
    yield holding
    holding.release()
