"""A simulated arm that the test's own program holds, and serves to others."""

from __future__ import annotations

import pytest

from armdrive import Arm
from armdrive.connect.control_socket import serve
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.storage.arm_lock import hold


@pytest.fixture
def arm():
    with Arm(connect_simulated(simulated_config("teachmover"))) as arm:
        yield arm


@pytest.fixture
def holding(arm):
    """Hold the arm by its name and by that of its port."""
    holding = hold("bench", "/dev/ttyUSB0")
    serve(holding, arm)
    yield holding
    holding.release()
