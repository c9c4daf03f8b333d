"""A lost wire is opened again once the old one has let its port go, and not before."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest
from waiting import LONG_S

from armdrive.connect import reconnect as mending
from armdrive.connect.reconnect import NewLink, Reconnector
from armdrive.errors import LinkLost, PortInUse


class OneHolder:
    """A port that one wire at a time can have; a wire is slow to let it go."""

    description = "can:slcan:/dev/ttyACM0"

    def __init__(self) -> None:
        self.asked_for, self.may_close, self.tried = (threading.Event() for _ in range(3))
        self.held = True

    def close(self) -> None:
        self.may_close.wait(LONG_S)
        self.held = False

    def open_again(self):
        if self.held:
            raise PortInUse("in use by another program or by this one")
        raise LinkLost("free, but nobody is there")

    def woken(self) -> None:
        self.tried.set()


@pytest.fixture
def port():
    held = OneHolder()
    yield held
    held.may_close.set()


def looking(port):
    """Return who looks for a wire that was lost a moment ago, and has begun to."""
    engine = SimpleNamespace(link=port)
    core = SimpleNamespace(diagnostics=SimpleNamespace(notify=lambda *_words: None))
    wire = SimpleNamespace(engine=engine, core=core, now_s=0.0)
    reconnector = Reconnector(wire, NewLink(port.open_again, in_thread=True))
    reconnector.lost(0.0)
    engine.link = SimpleNamespace(wake=port.woken)
    reconnector.ask(0.0)
    reconnector(0.0)
    return reconnector


def test_the_old_wire_is_waited_for(port):
    reconnector = looking(port)
    assert not port.tried.wait(0.05)
    port.may_close.set()
    assert port.tried.wait(LONG_S)
    reconnector(0.0)
    assert reconnector.tries == 1
    assert "nobody is there" in str(reconnector.trouble)


def test_an_old_wire_that_never_lets_go_is_waited_for_no_longer_than_that(port, monkeypatch):
    monkeypatch.setattr(mending, "LET_GO_S", 0.01)
    reconnector = looking(port)
    assert port.tried.wait(LONG_S)
    reconnector(0.0)
    assert isinstance(reconnector.trouble, PortInUse)
