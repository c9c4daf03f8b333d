"""For all tests: repeatable hypothesis runs, and a home folder each."""

import gc
import itertools
import os
import signal
import sys
from pathlib import Path

import pytest

if sys.dont_write_bytecode:
    # keep the bytecode elsewhere, because compiling costs each worker and child process seconds
    sys.dont_write_bytecode = False
    sys.pycache_prefix = str(Path(__file__).parents[1] / ".pytest_cache" / "bytecode")
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from _pytest.runner import runtestprotocol
from amounts import THOROUGH
from hypothesis import Phase, settings
from waiting import FOREVER_S

from armdrive.runtime import clock

GARBAGE = 200_000
"""The number of new objects after which Python searches for garbage. By its default it would search
all the time, because a desk and thousands of collected tests make so many objects."""
gc.set_threshold(GARBAGE, 20, 20)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell makes background jobs and their children ignore Ctrl-C
    signal.signal(signal.SIGINT, signal.default_int_handler)

# every day the same examples, which can only find what became worse: a few of them do
settings.register_profile("everyday", deadline=None, derandomize=True, max_examples=10)
settings.register_profile("thorough", deadline=None, max_examples=1000)
# where it only matters whether a test fails: the search for the shortest example takes longest
settings.register_profile(
    "unshrunk", settings.get_profile("everyday"), phases=[Phase.explicit, Phase.generate]
)
settings.load_profile(
    os.environ.get("HYPOTHESIS_PROFILE") or ("thorough" if THOROUGH else "everyday")
)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config):
    """Use one worker more than cores, because much of the time is waiting for processes."""
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    """Have a worker send one report of a test that passes, instead of five messages.

    To send and read the other four takes longer than many tests.
    """
    if not hasattr(item.config, "workerinput"):
        return None  # this process shows its reports by itself
    for report in runtestprotocol(item, log=False, nextitem=nextitem):
        if report.when == "call" or not report.passed:
            if report.passed:
                report.keywords = {}  # which take longer to send than all else
            item.ihook.pytest_runtest_logreport(report=report)
    return True


@pytest.hookimpl(trylast=True)
def pytest_collection_finish():
    """Exclude all present objects from later searches for garbage."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish():
    """Search once for garbage; pytest searches five more times, but only the objects since then."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def _folders(tmp_path_factory):
    """Yield names of folders."""
    folder = tmp_path_factory.mktemp("tests")
    return (folder / str(number) for number in itertools.count())


@pytest.fixture
def tmp_path(_folders):
    """Return a new folder.

    Pytest's own fixture searches for a free number, which takes longer with every test, and renews
    a link. Together that takes longer than most tests.
    """
    folder = next(_folders)
    folder.mkdir()
    return folder


@pytest.fixture(autouse=True)
def _a_busy_computer_suspends_nothing(monkeypatch):
    """Let an arm in real time wait for its turn, however long: a busy computer suspends nothing.

    A test of a suspension says how long one lasts, or suspends a process of its own.
    """
    monkeypatch.setattr(clock, "SUSPENDED_S", FOREVER_S)


@pytest.fixture(autouse=True)
def _own_home(_folders, monkeypatch):
    """Keep every test away from the user's arms, from real ports, and from disk syncs.

    Other tests check the order of syncs on simulated disks.
    """
    monkeypatch.setattr(os, "fsync", lambda _: None)
    monkeypatch.setenv("ARMDRIVE_HOME", str(next(_folders)))
    monkeypatch.delenv("ARMDRIVE_ARM", raising=False)
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
    monkeypatch.setenv("ARMDRIVE_TRACEBACK", "1")  # a fault fails the test, with its traceback
