"""No test of coroutines leaves a thread behind."""

from __future__ import annotations

import threading

import pytest


@pytest.fixture(autouse=True)
def _no_thread_stays():
    yield
    for each in threading.enumerate():
        if each.name == "armdrive call":
            each.join(timeout=5.0)
            assert not each.is_alive()
