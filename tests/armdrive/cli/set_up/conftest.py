"""A port with a simulated device behind it."""

from functools import partial

import pytest
from doctor_bench import lead
from serial.tools import list_ports as pyserial


@pytest.fixture
def port(tmp_path, monkeypatch):
    """Return an existing port that is no USB adapter; `lead_to` puts a device behind it."""
    device = tmp_path / "ttyUSB0"
    device.touch()
    monkeypatch.setattr(pyserial, "comports", list)
    return device


@pytest.fixture
def lead_to(port, monkeypatch):
    """Put a device behind the port; return the list of baud rates at which it is opened."""
    return partial(lead, monkeypatch, port)
