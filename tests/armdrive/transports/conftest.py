"""A CAN bus that fails on request, and how patient the driver is with one."""

from __future__ import annotations

import pytest
from can_bench import LONG_S, failing_link

from armdrive.transports import can_link, can_threads


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
