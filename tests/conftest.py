"""What all tests share: repeatable hypothesis runs, a home of their own, and options for an arm."""

from __future__ import annotations

import os
import signal

import pytest
from hypothesis import settings

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell starts jobs in the background deaf to Ctrl-C, and their children too
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("everyday", deadline=None, derandomize=True, max_examples=50)
settings.register_profile("thorough", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "everyday"))


def pytest_addoption(parser):
    """Name a real arm for the tests marked `hardware`; without one they are not even collected."""
    parser.addoption("--arm-port", metavar="PORT", help="the port of a real arm to be tested")
    parser.addoption("--arm-dialect", metavar="NAME", help="the dialect that it speaks")


def pytest_collection_modifyitems(config, items):
    """Leave the tests of a real arm out, unless one is named."""
    if config.getoption("--arm-port"):
        if not config.getoption("--arm-dialect"):
            raise pytest.UsageError("--arm-port needs --arm-dialect: nothing is sent to find out")
        return
    left = [item for item in items if item.get_closest_marker("hardware")]
    items[:] = [item for item in items if item not in left]
    config.hook.pytest_deselected(items=left)


@pytest.fixture
def arm_port(request):
    """Return the port of the real arm."""
    return request.config.getoption("--arm-port")


@pytest.fixture
def arm_dialect(request):
    """Return its dialect."""
    return request.config.getoption("--arm-dialect")


@pytest.fixture(autouse=True)
def _own_home(tmp_path_factory, monkeypatch):
    """Keep every test away from the user's own arms, and from any real port."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path_factory.mktemp("home")))
    monkeypatch.delenv("ARMDRIVE_ARM", raising=False)
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
