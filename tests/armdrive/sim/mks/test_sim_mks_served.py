"""Another program reaches the simulated drives by an adapter on a pseudo-terminal, in real time."""

from __future__ import annotations

import json
import sys

import can
import pytest
from cli_calls import Caller
from mks_sim import TURN, arm_config
from pages import page
from served import ServedDevice
from waiting import LONG_S

from armdrive.registry.simulate import simulate_device
from armdrive.sim.device import DrivesOnBus
from armdrive.sim.faults.table import FAULTS
from armdrive.sim.mks.kind import KIND
from armdrive.sim.serving.loop import make_server
from firmware_protocol import mks
from firmware_protocol.frames import Frame

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


class ServedDrives(ServedDevice):
    """The arm in a thread, its console on a pipe, and python-can at the other end."""

    def __init__(self, path) -> None:
        super().__init__(make_server(slcan=path), simulate_device(arm_config()))

    def open(self) -> can.BusABC:
        return can.Bus(
            interface="slcan", channel=self.server.address, bitrate=500_000, sleep_after_open=0.0
        )


@pytest.fixture
def served(tmp_path):
    running = ServedDrives(tmp_path / "can0")
    yield running
    running.end()


def say(bus: can.BusABC, node: int, request: mks.Request) -> None:
    frame = mks.encode(node, request)
    bus.send(can.Message(arbitration_id=node, data=frame.data, is_extended_id=False))


def hear(bus: can.BusABC, timeout_s: float = LONG_S):
    message = bus.recv(timeout_s)
    if message is None:
        return None
    return mks.decode_answer(Frame(message.arbitration_id, bytes(message.data)))


@needs_pty
def test_python_can_moves_the_arm_and_the_console_shows_it(served):
    with served.open() as bus:
        say(bus, 1, mks.MoveAbsoluteAxis(TURN // 8, 300, 0))
        assert hear(bus).outcome is mks.Outcome.STARTED
        assert hear(bus).outcome is mks.Outcome.DONE
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus) == mks.EncoderRead(TURN // 8)
    state = json.loads(served.tell("state --json"))
    assert state["registers"] == [TURN // 8, 0, 0, 0, 0, 0]
    assert state["drives"][0]["mode"] == "bus_foc"
    assert "current on" in served.tell("state")


@needs_pty
def test_its_adapter_leaves_the_bus_until_it_is_opened_anew(served):
    with served.open() as bus:
        served.tell("fault bus-off")
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus, 0.1) is None
        assert served.server.adapter.refused == 1
    with served.open() as bus:
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus).code is mks.Code.ENCODER
        assert served.tell("fault") == "no faults"
        served.tell("fault alone")
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus, 0.1) is None
        served.tell("fault off")
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus).code is mks.Code.ENCODER


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["mks", "--pty", "x"], "--slcan PATH is required"),
        (["mks"], "--slcan PATH is required"),
        (["teachmover", "--slcan", "x"], "--pty PATH offers it"),
    ],
)
def test_each_device_is_offered_over_a_wire_of_its_kind(capsys, words, told):
    assert told in Caller(capsys)("sim", *words, code=2).err


def test_the_list_tells_its_settings_and_faults(capsys):
    out = Caller(capsys)("sim", "mks", "--list").out
    assert "firmware=file" in out
    assert "drive-reset MOTOR" in out
    assert "drive-reset" not in Caller(capsys)("sim", "grbl", "--list").out


def test_the_page_tells_every_setting_and_every_fault_of_the_bus():
    text = page("simulating")
    for option in KIND.options:
        assert f"| `{option.name}` |" in text
    for name, kind in FAULTS.items():
        assert f"`{name}`" in text or kind.needs is not DrivesOnBus


@needs_pty
def test_drives_are_plugged_in_and_pulled_one_by_one(served):
    with served.open() as bus:
        assert served.tell("plug 2 3") == "on the bus: shoulder, elbow"
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus, 0.1) is None
        say(bus, 3, mks.ReadEncoder())
        assert hear(bus) == mks.EncoderRead(0)
        assert "numbered 1 to 6" in served.tell("plug 7")
        assert served.tell("plug none") == "on the bus: none"
        served.tell("plug all")
        say(bus, 1, mks.ReadEncoder())
        assert hear(bus) == mks.EncoderRead(0)
