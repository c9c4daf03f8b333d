"""What all tests share: repeatable hypothesis runs, and a home of their own."""

from __future__ import annotations

import pytest
from hypothesis import settings

settings.register_profile("repeatable", deadline=None, derandomize=True, print_blob=False)
settings.load_profile("repeatable")


@pytest.fixture(autouse=True)
def _own_home(tmp_path_factory, monkeypatch):
    """Keep every test away from the user's own arms, and from any real port."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path_factory.mktemp("home")))
    monkeypatch.delenv("ARMDRIVE_ARM", raising=False)
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
