"""End to end, a simulated arm on a pty, and commands on it in processes of their own."""

import signal
import sys
from contextlib import contextmanager

import pytest
from amounts import amount
from command_host import HostedCommand
from waiting import LONG_S, suspended, until

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

from served import Served

SUSPENDED_S = 1.5
"""Longer than what a driver takes for a busy computer."""


@pytest.fixture(scope="module")
def sim(tmp_path_factory):
    """Return one arm for all tests, each of which begins by bringing it to its reference."""
    with Served("teachmover", pty=tmp_path_factory.mktemp("pty") / "arm") as sim:
        yield sim


def arm_on(sim) -> tuple[str, ...]:
    """Return the options that name the simulated arm on its port."""
    return ("--port", sim.port, "--dialect", "teachmover")


class Moving:
    """`armdrive move` in a process of its own, on a way of a minute, seen to move."""

    def __init__(self, sim: Served) -> None:
        words = ["move", "--base", "80", "--speed", "5%", "--allow-restored", *arm_on(sim)]
        self.process = HostedCommand(*words)
        sim.watch.wait_until_moving()

    def end(self) -> tuple[int, str]:
        """Wait for its end; return its exit code and what it complained of."""
        _, err = self.process.communicate(timeout=LONG_S)
        assert "Traceback" not in err
        return self.process.returncode, err


@contextmanager
def under_way(call, sim):
    call("home", "--yes", *arm_on(sim), code=0)
    moving = Moving(sim)
    yield moving
    moving.process.kill()
    moving.process.communicate()


@pytest.fixture
def moving(call, sim):
    with under_way(call, sim) as moving:
        yield moving


def stop_time_s(call, sim) -> float:
    """Ask the program that holds the arm what a stop may take now."""
    return float(status_of(call, sim)["stop_time_s"])


def status_of(call, sim):
    """Return the status of the arm on its port."""
    return call("status", *arm_on(sim), "--json", code=0).json


def test_a_restored_position_of_a_real_arm_wants_to_be_confirmed(call, sim):
    call("home", "--yes", *arm_on(sim), code=0)
    called = call("move", "--z", "10", *arm_on(sim), code=3)
    assert "--allow-restored" in called.err
    assert not sim.look()[1]["moving"]


def test_a_stop_from_another_terminal_ends_a_move(call, sim, moving):
    bound_s = stop_time_s(call, sim)
    call("stop", *arm_on(sim), code=0)
    code, err = moving.end()
    sim.watch.stands_within(bound_s)
    assert code == 5
    assert err.startswith("armdrive: ")
    assert err.count("\n") == 1
    assert status_of(call, sim)["trust"] == "restored"


@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGTERM, 143), (signal.SIGKILL, -9), (signal.SIGINT, 130)][: amount(2, 3)],
)
def test_a_move_that_is_ended_by_a_signal_leaves_a_still_arm(call, sim, moving, number, code):
    bound_s = stop_time_s(call, sim)
    moving.process.send_signal(number)
    ended, err = moving.end()
    sim.watch.stands_within(bound_s)
    assert ended == code
    assert ("that this command moved was stopped" in err) == (number is not signal.SIGKILL)
    assert status_of(call, sim)["trust"] == ("suspect" if number is signal.SIGKILL else "restored")


def test_a_move_that_was_suspended_does_not_go_on_when_it_wakes(call, sim, moving):
    moving.process.send_signal(signal.SIGSTOP)
    until(lambda: suspended(moving.process.pid), "the program was not suspended")
    stood = sim.watch.rest()
    sim.watch.passes(SUSPENDED_S)
    moving.process.send_signal(signal.SIGCONT)
    code, err = moving.end()
    assert code == 5
    assert "was suspended for" in err
    assert sim.watch.motors == stood
