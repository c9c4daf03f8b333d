"""What all tests share: repeatable hypothesis runs, a home of their own, and options for an arm."""

from __future__ import annotations

import gc
import itertools
import os
import signal
import sys
from pathlib import Path

import pytest

if sys.dont_write_bytecode:
    # to compile everything anew costs each worker and each child seconds: kept, but elsewhere
    sys.dont_write_bytecode = False
    sys.pycache_prefix = str(Path(__file__).parents[1] / ".pytest_cache" / "bytecode")
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from amounts import THOROUGH
from hypothesis import Phase, settings

GARBAGE = 50_000
"""So many new objects let the collector search: a desk makes so many that it would all the time,
and so do thousands of tests that are collected."""
gc.set_threshold(GARBAGE, 20, 20)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell starts jobs in the background deaf to Ctrl-C, and their children too
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("everyday", deadline=None, derandomize=True, max_examples=20)
settings.register_profile("thorough", deadline=None, max_examples=1000)
# where it only matters whether a test fails: the search for the shortest example takes longest
settings.register_profile(
    "unshrunk", settings.get_profile("everyday"), phases=[Phase.explicit, Phase.generate]
)
settings.load_profile(
    os.environ.get("HYPOTHESIS_PROFILE") or ("thorough" if THOROUGH else "everyday")
)


def pytest_addoption(parser):
    """Name a real arm for the tests marked `hardware`; without one they are not even collected."""
    parser.addoption("--arm-port", metavar="PORT", help="the port of a real arm to be tested")
    parser.addoption("--arm-dialect", metavar="NAME", help="the dialect that it speaks")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config):
    """Have one worker more than cores: much of the time goes by in waiting for real processes.

    A real arm has one worker: what its first test confirms, the next one takes up.
    """
    if config.getoption("--arm-port"):
        return 1
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None
    return (os.cpu_count() or 1) + 1


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


@pytest.hookimpl(trylast=True)
def pytest_collection_finish():
    """Leave what stays until the end out of every later search for garbage, and search less."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish():
    """Search once for what nobody has closed; pytest does it five times more, of what is left."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def _folders(tmp_path_factory):
    """Return names of folders, one after the other."""
    folder = tmp_path_factory.mktemp("tests")
    return (folder / str(number) for number in itertools.count())


@pytest.fixture
def tmp_path(_folders):
    """Return a new folder.

    For each folder, pytest's own fixture searches for a free number, which takes longer with every
    test, and renews a link to it: together longer than most tests take.
    """
    folder = next(_folders)
    folder.mkdir()
    return folder


@pytest.fixture(autouse=True)
def _own_home(_folders, monkeypatch):
    """Keep every test away from the user's own arms, and from any real port, and off the disk.

    The order in which a record is brought to the disk is tested on disks of the tests' own.
    """
    monkeypatch.setattr(os, "fsync", lambda _: None)
    monkeypatch.setenv("ARMDRIVE_HOME", str(next(_folders)))
    monkeypatch.delenv("ARMDRIVE_ARM", raising=False)
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
    monkeypatch.setenv("ARMDRIVE_TRACEBACK", "1")  # a fault fails the test, with its traceback
