"""An arm of drives on a bus of another process: what is wrong with the bus is said, and mended."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from armdrive import Arm
from armdrive.connect.port import PortOpening
from armdrive.connect.target import find
from armdrive.errors import ArmError, PortUnavailable
from armdrive.status import State, Trust
from armdrive.transports import opening as url

sys.path.insert(0, str(Path(__file__).parents[4] / "benchmarks"))
from sim_process import SimProcess

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
PORT = "can:slcan:/dev/ttyACM0?bitrate=500000"


@pytest.mark.parametrize(
    ("port", "heard"),
    [
        (PORT, f"{PORT}&ids=1,2,3,4,5,9"),
        (f"{PORT}&ids=1,2", f"{PORT}&ids=1,2"),
        ("/dev/ttyACM0", "/dev/ttyACM0"),
    ],
)
def test_only_the_ids_of_the_arm_are_listened_to(port, heard, monkeypatch):
    opened = []
    monkeypatch.setattr(url, "open_link", lambda name, *_words, **_named: opened.append(name))
    config = find(PORT, dialect_name="mks").config
    device = replace(config.device, ids=(1, 2, 3, 4, 5, 9))
    wire = replace(config.connection, port=port)
    PortOpening(replace(config, device=device, connection=wire)).open()
    assert opened == [heard]


def test_a_bus_that_this_computer_does_not_have_is_refused_in_words():
    with pytest.raises(PortUnavailable):
        Arm.connect("can:socketcan:can99", dialect="mks")


def looked_at(arm, times):
    """Look at an arm again and again."""
    for _ in range(times):
        arm.sleep(0.05)
        arm.read_inputs()


@needs_pty
def test_an_adapter_that_left_the_bus_comes_back_within_the_same_program(tmp_path):
    path = tmp_path / "can0"
    with SimProcess(path, "mks") as bus, Arm.connect(bus.port, dialect="mks") as arm:
        before = bus.state()["motors"]
        bus.say("fault bus-off")
        with pytest.raises(ArmError):
            looked_at(arm, 200)
        assert arm.status.trust is not Trust.REFERENCED
        bus.say("fault off")
        if arm.status.state is State.DISCONNECTED:  # at once: the adapter is let go of before
            arm.reconnect()
        arm.reset()
        arm.enable()
        assert arm.status.state is State.STANDBY
        assert bus.state()["motors"] == before
