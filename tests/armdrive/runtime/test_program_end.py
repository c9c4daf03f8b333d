"""How a program ends, and the signals that reach it."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from forking import host as hosting
from pages import page
from served import Served
from waiting import suspended, until

from armdrive import Arm
from armdrive.runtime import clock
from armdrive.runtime.clock import SignalsBetweenSteps
from armdrive.status import Trust

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)


UNDER_WAY = 25
"""Steps of the base after which a motion is well under way, in its second burst."""

SUSPENDED_S = 1.2
"""Longer than the driver takes for a pause of its own computer."""


@pytest.fixture(scope="module", name="host")
def running_host():
    """A process whose children drive arms."""
    with hosting("ending_host.py") as host:
        yield host
        host.stdin.close()


class Ground:
    """A simulated arm, and a program that drives it in a child for each way to end."""

    def __init__(self, host: subprocess.Popen, folder: Path, dialect: str) -> None:
        self.sim = Served(dialect, pty=folder / "arm")
        self.dialect = dialect
        self.errors = folder / "errors"
        self._child = 0
        self._host = host

    def __enter__(self) -> "Ground":
        return self

    def __exit__(self, *_: object) -> None:
        """End all, a program that a test has left alive included: it would be waited for."""
        if self._child:
            os.kill(self._child, signal.SIGKILL)
            self.told()
        self.sim.end()

    def begin(self, **order) -> tuple[int, float]:
        """Have a child set out; return its number and the time within which the arm shall stand."""
        order |= {"port": self.sim.port, "dialect": self.dialect, "motors": self.motors}
        order["home"] = os.environ["ARMDRIVE_HOME"]
        self._host.stdin.write(json.dumps(order) + "\n")
        told = self.told()
        assert "ended" not in told, told
        self.sim.watch.moves_by(UNDER_WAY)
        self._host.stdin.write("\n")
        told = self.told()
        assert "silent_s" in told, told
        return told["pid"], max(told["silent_s"], told["stop_s"])

    @property
    def motors(self) -> list[int]:
        return self.sim.watch.motors

    def told(self) -> dict:
        told = json.loads(self._host.stdout.readline())
        self._child = 0 if "ended" in told else told["pid"]
        return told

    def stands_within(self, bound_s: float) -> None:
        """Check how long the arm moved on once it had heard the last of an ended program."""
        self.sim.watch.stands_within(bound_s)

    def ended(self, bound_s: float) -> int:
        """Wait until the program has ended, and hold the arm to its bound; return the exit code."""
        code = self.told()["ended"]
        self.stands_within(bound_s)
        return code


def by_signal(number: int) -> Callable[[Ground], int]:
    def end(ground: Ground) -> int:
        child, bound_s = ground.begin()
        os.kill(child, number)
        return ground.ended(bound_s)

    return end


def by_exception(ground: Ground) -> int:
    _, bound_s = ground.begin(raises=True)
    return ground.ended(bound_s)


def by_closing_its_terminal(ground: Ground) -> int:
    master, slave = os.openpty()
    _, bound_s = ground.begin(terminal=os.ttyname(slave))
    os.close(slave)
    os.close(master)
    return ground.ended(bound_s)


def by_suspending(ground: Ground) -> int:
    """Suspend it, and let it go on: the motion does not."""
    child, bound_s = ground.begin()
    os.kill(child, signal.SIGSTOP)
    until(lambda: suspended(child), "the program was not suspended")
    ground.stands_within(bound_s)
    stood = ground.motors
    ground.sim.watch.passes(SUSPENDED_S)
    os.kill(child, signal.SIGCONT)
    ground.sim.watch.passes(0.3)
    assert ground.motors == stood
    with contextlib.suppress(ProcessLookupError):
        os.kill(child, signal.SIGTERM)
    return ground.told()["ended"]


FORGETFUL = """
import os, select, sys
from armdrive import Arm, LinkLost
arm = Arm.connect(order["port"], dialect=order["dialect"])
arm.enable()
arm.reference.confirm()
arm.move_j(base_deg=60, speed=0.3, wait=False)
under_way(arm)
while not select.select([0], [], [], 0.05)[0]:
    pass  # short waits: Python notices a signal that comes just before one only after it
os.read(0, 1)
if os.fork() == 0:
    for call in (arm.stop, arm.estop, arm.io.read, lambda: arm.move_j(base_deg=0)):
        try:
            call()
        except LinkLost as error:
            assert "was forked" in str(error)
        else:
            os._exit(1)
    arm.close()
    sys.exit()
assert os.wait()[1] == 0
assert not arm.closed
"""
"""A script that forgets to close its arm. A forked child neither drives nor closes it."""

(AT_SIGTERM,) = re.findall(r"(?s)```python\n(import signal.*?)```", page("python"))
"""What the page tells a script to do to end well at SIGTERM."""

FORGOTTEN = (
    (FORGETFUL, None, 0, Trust.RESTORED),
    (AT_SIGTERM + FORGETFUL, signal.SIGTERM, 128 + signal.SIGTERM, Trust.RESTORED),
    (FORGETFUL, signal.SIGTERM, -signal.SIGTERM, Trust.SUSPECT),
)


def test_a_script_that_forgets_to_close_its_arm_ends_as_the_page_says(host, tmp_path):
    with Ground(host, tmp_path, "teachmover") as ground:
        for text, number, code, trust in FORGOTTEN:
            child, bound_s = ground.begin(script=text, errors=str(ground.errors))
            if number is None:
                host.stdin.write("\n")
            else:
                os.kill(child, number)
            assert ground.ended(bound_s) == code
            assert ground.errors.read_text() == ""
            with Arm.connect(ground.sim.port, dialect="teachmover") as arm:
                assert arm.status.trust is trust


ENDINGS = (
    (by_exception, 1),
    (by_signal(signal.SIGTERM), 143),
    (by_closing_its_terminal, 129),  # the kernel sends SIGHUP
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
    ("dialect", "endings"), [("teachmover", ENDINGS), ("grbl", (ENDINGS[-1],))]
)
def test_the_arm_stands_however_its_program_ends(host, tmp_path, dialect, endings):
    with Ground(host, tmp_path, dialect) as ground:
        found = [moved(ground, end) for end, _ in endings]
    assert found == [code for _, code in endings]


# -- Signals between two steps ---------------------------------------------------------------------


@pytest.fixture
def handled():
    """Record SIGINT and SIGTERM instead of ending the tests."""
    numbers = []
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, lambda number, _: numbers.append(number))
    yield numbers
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_signal_waits_for_the_end_of_the_step(handled):
    with SignalsBetweenSteps() as signals:
        signal.raise_signal(signal.SIGINT)
        assert handled == []
        signals.deliver()
        assert handled == [signal.SIGINT]
        signal.raise_signal(signal.SIGTERM)
    assert handled == [signal.SIGINT, signal.SIGTERM]


def interrupting(number, _):
    raise InterruptedError(number)


@pytest.mark.parametrize(
    ("interrupted", "other", "sets"),
    [(signal.SIGTERM, signal.SIGINT, 1), (signal.SIGINT, signal.SIGTERM, 3)],
    ids=["as it begins", "as it ends"],
)
def test_a_handler_that_raises_in_between_leaves_the_other_signals_working(
    handled, monkeypatch, interrupted, other, sets
):
    """The signal comes after as many handlers have been set: two at first, two at the end."""
    signal.signal(interrupted, interrupting)
    left = iter([False] * (sets - 1) + [True])
    change = signal.signal

    def changing(number, handler):
        before = change(number, handler)
        if next(left, False):
            signal.raise_signal(interrupted)
        return before

    monkeypatch.setattr(clock.signal, "signal", changing)
    with pytest.raises(InterruptedError), SignalsBetweenSteps():
        pass
    signal.raise_signal(other)
    assert handled == [other]
