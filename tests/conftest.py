"""What all tests share: repeatable hypothesis runs, and a home of their own."""

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


@pytest.fixture(autouse=True)
def _own_home(tmp_path_factory, monkeypatch):
    """Keep every test away from the user's own arms, and from any real port."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path_factory.mktemp("home")))
    monkeypatch.delenv("ARMDRIVE_ARM", raising=False)
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
