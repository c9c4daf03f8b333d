"""However a program ends, the physical arm stands within the announced time: really, over a pty.

One dialect that gets bursts and one that queues. The simulated arm, the program and this test are
three processes; what is looked at is the simulated world.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from sim_process import SimProcess

HOST = Path(__file__).with_name("ending_host.py")
NOISE_S = 0.25
"""What a busy computer may add to a time."""

UNDER_WAY_S = 0.15
"""Long enough for a motion to have reached its speed."""

SUSPENDED_S = 1.2
"""Longer than the driver takes for a pause of its own computer."""


class Ground:
    """A simulated arm, and a program that drives it in a child for each way to end."""

    def __init__(self, folder: Path, dialect: str) -> None:
        self.sim = SimProcess(folder / "arm", dialect)
        self._host = subprocess.Popen(
            [sys.executable, str(HOST), self.sim.port, dialect],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )

    def close(self) -> None:
        self._host.communicate()
        self.sim.__exit__()

    def begin(self, **order) -> tuple[int, float]:
        """Have a child set out; return its number and the time within which the arm shall stand."""
        self._host.stdin.write(json.dumps({"motors": self.motors, **order}) + "\n")
        told = self.told()
        assert "ended" not in told, told
        self.sim.wait_until_moving()
        time.sleep(UNDER_WAY_S)
        self._host.stdin.write("\n")
        told = self.told()
        assert "silent_s" in told, told
        return told["pid"], max(told["silent_s"], told["stop_s"])

    @property
    def motors(self) -> list[int]:
        return list(self.sim.state()["motors"])

    def told(self) -> dict:
        return json.loads(self._host.stdout.readline())

    def stands_within(self, bound_s: float, since_s: float) -> None:
        assert self.sim.rest_after_s(since_s) < bound_s + NOISE_S


def by_signal(number: int) -> Callable[[Ground], int]:
    def end(ground: Ground) -> int:
        child, bound_s = ground.begin()
        since_s = time.monotonic()
        os.kill(child, number)
        ground.stands_within(bound_s, since_s)
        return ground.told()["ended"]

    return end


def by_exception(ground: Ground) -> int:
    _, bound_s = ground.begin(raises=True)
    ground.stands_within(bound_s, time.monotonic())
    return ground.told()["ended"]


def by_closing_its_terminal(ground: Ground) -> int:
    master, slave = os.openpty()
    _, bound_s = ground.begin(terminal=os.ttyname(slave))
    os.close(slave)
    since_s = time.monotonic()
    os.close(master)
    ground.stands_within(bound_s, since_s)
    return ground.told()["ended"]


def by_suspending(ground: Ground) -> int:
    """Suspend it, and let it go on: the motion does not."""
    child, bound_s = ground.begin()
    since_s = time.monotonic()
    os.kill(child, signal.SIGSTOP)
    ground.stands_within(bound_s, since_s)
    stood = ground.motors
    time.sleep(max(SUSPENDED_S - (time.monotonic() - since_s), 0.0))
    os.kill(child, signal.SIGCONT)
    time.sleep(0.3)
    assert ground.motors == stood
    with contextlib.suppress(ProcessLookupError):
        os.kill(child, signal.SIGTERM)
    return ground.told()["ended"]


ENDINGS = (
    (by_exception, 1),
    (by_signal(signal.SIGTERM), 143),
    (by_signal(signal.SIGHUP), 129),
    (by_closing_its_terminal, 129),
    (by_suspending, 143),
    (by_signal(signal.SIGKILL), -signal.SIGKILL),
)


def moved(ground: Ground, end: Callable[[Ground], int]) -> int:
    """End a program, and check that there was a motion to be ended, far from its goal."""
    before = ground.motors
    code = end(ground)
    assert 0 < abs(ground.motors[0] - before[0]) < 1500  # of the 1571 to 3142 that were asked for
    return code


@pytest.mark.parametrize(
    ("dialect", "endings"), [("teachmover", ENDINGS), ("grbl", (*ENDINGS[:1], *ENDINGS[3:]))]
)
def test_the_arm_stands_however_its_program_ends(tmp_path, dialect, endings):
    ground = Ground(tmp_path, dialect)
    try:
        found = [moved(ground, end) for end, _ in endings]
    finally:
        ground.close()
    assert found == [code for _, code in endings]
