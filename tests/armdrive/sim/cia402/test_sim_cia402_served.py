"""Another program reaches the simulated CiA 402 drives by an adapter on a pseudo-terminal."""

from __future__ import annotations

import json
import sys

import can
import pytest
from cia402_sim import arm_config
from cli_calls import Caller
from pages import page
from served import ServedDevice
from waiting import LONG_S

from armdrive.registry.simulate import simulate_device
from armdrive.sim.cia402.kind import KIND
from armdrive.sim.device import SaysEmergencies
from armdrive.sim.faults.table import FAULTS
from armdrive.sim.serving.loop import make_server
from firmware_protocol.canopen import (
    DEVICE_TYPE,
    DataType,
    Emergency,
    Place,
    SdoClient,
    Uploaded,
)
from firmware_protocol.frames import Frame

NODE = 3


@pytest.fixture
def served(tmp_path):
    server = make_server(slcan=tmp_path / "can0")
    running = ServedDevice(server, simulate_device(arm_config()))
    yield running
    running.end()


def upload(bus: can.BusABC, place: Place) -> bytes:
    client = SdoClient(NODE)
    request = client.upload(place)
    while request is not None:
        bus.send(
            can.Message(arbitration_id=request.can_id, data=request.data, is_extended_id=False)
        )
        request = client.receive_frame(heard(bus))
    ended = client.next_event()
    assert isinstance(ended, Uploaded)
    return ended.data


def heard(bus: can.BusABC) -> Frame:
    message = bus.recv(LONG_S)
    assert message is not None, "the drives say nothing"
    return Frame(message.arbitration_id, bytes(message.data))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_python_can_asks_a_drive_and_the_console_steers_it(served):
    with can.Bus(
        interface="slcan", channel=served.server.address, bitrate=500_000, sleep_after_open=0.0
    ) as bus:
        assert DataType.U32.unpack(upload(bus, DEVICE_TYPE)) == 0x0004_0192
        assert upload(bus, Place(0x1008)) == b"Simulated CiA 402 servo drive"
        served.tell(f"fault drive-fault {NODE} 4310")
        emergency = Emergency.read(heard(bus))
        assert (emergency.node, emergency.words) == (NODE, "drive too hot")
    drive = json.loads(served.tell("state --json"))["drives"][NODE - 1]
    assert (drive["id"], drive["nmt"], drive["state"]) == (NODE, "pre_operational", "fault")
    assert drive["error_code"] == "4310"
    assert served.tell("plug 2") == "on the bus: shoulder"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["cia402", "--pty", "x"], "--slcan PATH is required"),
        (["cia402", "--slcan", "x", "--set", "missing=6"], "missing is written"),
    ],
)
def test_what_cannot_be_offered_is_refused(capsys, words, told):
    assert told in Caller(capsys)("sim", *words, code=2).err


def test_the_list_tells_its_settings_and_faults(capsys):
    out = Caller(capsys)("sim", "cia402", "--list").out
    assert "hold_after_loss=hold" in out
    assert "drive-fault MOTOR CODE" in out
    assert "drive-fault" not in Caller(capsys)("sim", "mks", "--list").out


def test_the_page_tells_every_setting_and_every_fault_of_such_drives():
    section = page("simulating").split("# CiA 402 drives")[1]
    for option in KIND.options:
        assert f"| `{option.name}` |" in section
    for name, kind in FAULTS.items():
        assert f"`{name}`" in section or kind.needs is not SaysEmergencies
