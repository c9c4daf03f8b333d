"""What several tests share: calling commands, a port that leads somewhere, a bus that fails."""

from __future__ import annotations

from functools import partial
from textwrap import dedent

import pytest
from can_bench import LONG_S, failing_link
from chain_files import shown_links
from cli_calls import Caller
from doctor_bench import lead
from serial.tools import list_ports as pyserial

from armdrive.cli.set_up import doctor
from armdrive.status import SchedulingJitter
from armdrive.transports import can_link, can_threads


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


@pytest.fixture
def own(tmp_path):
    """Return a link table of the reader's own: the one that the docs show."""
    path = tmp_path / "mine.toml"
    path.write_text(shown_links(), encoding="utf-8")
    return str(path)


@pytest.fixture
def _punctual(monkeypatch):
    """Have the doctor find the computer punctual at once, however busy it is with tests."""
    monkeypatch.setattr(doctor, "measured_jitter", lambda: SchedulingJitter(60, 1e-4, 2e-4, 3e-4))


@pytest.fixture
def port(tmp_path, monkeypatch, _punctual):
    """Return a port that is there and is no USB adapter; `lead_to` says what it leads to."""
    device = tmp_path / "ttyUSB0"
    device.touch()
    monkeypatch.setattr(pyserial, "comports", list)
    return device


@pytest.fixture
def lead_to(port, monkeypatch):
    """Have the port lead to a device; returns the openings."""
    return partial(lead, monkeypatch, port)


@pytest.fixture
def short_patience(monkeypatch):
    """Have what must last to be a loss last less, so that tests are quick."""
    monkeypatch.setattr(can_threads, "WATCH_PATIENCE_S", 0.1)
    monkeypatch.setattr(can_threads, "PATIENCE_S", 0.3)


@pytest.fixture
def never_stale(monkeypatch):
    """Have a frame that waits for a busy computer sent all the same."""
    monkeypatch.setattr(can_threads, "FRESH_S", LONG_S)


@pytest.fixture
def patient(monkeypatch):
    """Have nothing be a loss because it lasts."""
    monkeypatch.setattr(can_threads, "WATCH_PATIENCE_S", LONG_S)
    monkeypatch.setattr(can_threads, "PATIENCE_S", LONG_S)
    monkeypatch.setattr(can_link, "DRAIN_S", LONG_S)


@pytest.fixture
def failing():
    """Return a bus that fails on request, and the link on it."""
    bus, link = failing_link()
    yield bus, link
    bus.stuck.set()
    link.close()
