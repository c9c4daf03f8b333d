"""Checks that no test of coroutines leaves a thread behind."""

import threading

import pytest
from waiting import LONG_S


@pytest.fixture(autouse=True)
def _no_thread_stays():
    yield
    for each in threading.enumerate():
        if each.name == "armdrive call":
            each.join(LONG_S)
            assert not each.is_alive()
