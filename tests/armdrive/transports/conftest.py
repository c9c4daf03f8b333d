"""A CAN bus that fails on request, and the timeouts of the driver."""

import pytest
from can_bench import LONG_S, failing_link

from armdrive.transports import can_link


@pytest.fixture
def short_patience(monkeypatch):
    """Shorten the timeouts after which a link counts as lost, so that tests are quick."""
    monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", 0.1)
    monkeypatch.setattr(can_link, "PATIENCE_S", 0.3)


@pytest.fixture
def never_stale(monkeypatch):
    """Never drop a frame as stale, however busy the computer is."""
    monkeypatch.setattr(can_link, "FRESH_S", LONG_S)


@pytest.fixture
def patient(monkeypatch):
    """Lengthen the timeouts, so that no link counts as lost because of a delay."""
    monkeypatch.setattr(can_link, "WATCH_PATIENCE_S", LONG_S)
    monkeypatch.setattr(can_link, "PATIENCE_S", LONG_S)
    monkeypatch.setattr(can_link, "DRAIN_S", LONG_S)


@pytest.fixture
def failing():
    """Return a bus that fails on request, and the link on it."""
    bus, link = failing_link()
    yield bus, link
    bus.stuck.set()
    link.close()
