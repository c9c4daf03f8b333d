"""Another program reaches the simulated drives by an adapter on a pseudo-terminal, in real time."""

import json
import sys

import can
import pytest
from bus_sim import bus_arm
from cli_calls import Caller
from pages import page
from served import ServedDevice
from waiting import LONG_S

from armdrive.registry import simulate
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import SaysEmergencies
from armdrive.sim.faults import FAULTS
from armdrive.sim.serving import make_server
from firmware_protocol import mks
from firmware_protocol.frames import Frame

TURN = 0x4000
needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


class ServedDrives(ServedDevice):
    """The arm in a thread, its console on a pipe, and python-can at the other end."""

    def __init__(self, dialect, path) -> None:
        super().__init__(make_server(slcan=path), simulate(bus_arm(dialect)).device)

    def open(self) -> can.BusABC:
        return can.Bus(
            interface="slcan", channel=self.server.address, bitrate=500_000, sleep_after_open=0.0
        )


def say(bus: can.BusABC, frame: Frame) -> None:
    bus.send(can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False))


def hear(bus: can.BusABC, timeout_s: float = LONG_S) -> Frame | None:
    message = bus.recv(timeout_s)
    return None if message is None else Frame(message.arbitration_id, bytes(message.data))


def answer(bus: can.BusABC):
    """Return what an MKS drive says next."""
    return mks.decode_answer(hear(bus))


@pytest.fixture
def served(tmp_path):
    running = ServedDrives("mks", tmp_path / "can0")
    yield running
    running.end()


@needs_pty
def test_python_can_moves_the_arm_and_the_console_shows_it(served):
    with served.open() as bus:
        say(bus, mks.encode(1, mks.MoveAbsoluteAxis(TURN // 8, 300, 0)))
        assert answer(bus).outcome is mks.Outcome.STARTED
        assert answer(bus).outcome is mks.Outcome.DONE
        say(bus, mks.encode(1, mks.ReadEncoder()))
        assert answer(bus) == mks.EncoderRead(TURN // 8)
    state = json.loads(served.tell("state --json"))
    assert state["registers"] == [TURN // 8, 0, 0, 0, 0, 0]
    assert state["drives"][0]["mode"] == "bus_foc"
    assert "current on" in served.tell("state")


@needs_pty
def test_its_adapter_leaves_the_bus_until_it_is_opened_anew(served):
    ask = mks.encode(1, mks.ReadEncoder())
    with served.open() as bus:
        served.tell("fault bus-off")
        say(bus, ask)
        assert hear(bus, 0.1) is None
        assert served.server.adapters[0].refused == 1
    with served.open() as bus:
        say(bus, ask)
        assert answer(bus).code is mks.Code.ENCODER
        assert served.tell("fault") == "no faults"
        served.tell("fault alone")
        say(bus, ask)
        assert hear(bus, 0.1) is None
        assert served.server.adapters[0].refused == 1
        served.tell("fault off")
        say(bus, ask)
        assert answer(bus).code is mks.Code.ENCODER


@needs_pty
def test_drives_are_plugged_in_and_pulled_one_by_one(served):
    ask = {node: mks.encode(node, mks.ReadEncoder()) for node in (1, 3)}
    with served.open() as bus:
        assert served.tell("plug 2 3") == "on the bus: shoulder, elbow"
        say(bus, ask[1])
        assert hear(bus, 0.1) is None
        say(bus, ask[3])
        assert answer(bus) == mks.EncoderRead(0)
        assert "numbered 1 to 6" in served.tell("plug 7")
        assert served.tell("plug none") == "on the bus: none"
        served.tell("plug all")
        say(bus, ask[1])
        assert answer(bus) == mks.EncoderRead(0)


@needs_pty
def test_both_adapters_of_a_bus_are_pulled_and_put_back(tmp_path):
    paths = [tmp_path / "can0", tmp_path / "can1"]
    server = make_server(slcan=paths[0], listener=paths[1])
    server.close()
    assert not any(path.is_symlink() for path in paths)
    server.open()
    assert all(path.is_symlink() for path in paths)
    server.close()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("mks --pty x", "--slcan PATH is required"),
        ("mks", "--slcan PATH is required"),
        ("cia402 --pty x", "--slcan PATH is required"),
        ("cia402 --slcan x --set missing=6", "missing is written"),
        ("teachmover --slcan x", "is not spoken on a CAN bus: --pty PATH"),
    ],
)
def test_each_device_is_offered_over_a_wire_of_its_kind(capsys, words, told):
    assert told in Caller(capsys)("sim", *words.split(), code=2).err


@pytest.mark.parametrize(
    ("dialect", "option", "fault", "other"),
    [
        ("mks", "firmware=file", "drive-reset MOTOR", "grbl"),
        ("cia402", "hold_after_loss=hold", "drive-fault MOTOR CODE", "mks"),
    ],
)
def test_the_list_tells_its_settings_and_faults(capsys, dialect, option, fault, other):
    out = Caller(capsys)("sim", dialect, "--list").out
    assert option in out
    assert fault in out
    assert fault.split()[0] not in Caller(capsys)("sim", other, "--list").out


@pytest.mark.parametrize(
    ("needs", "begins"), [(DrivesBoard, "# MKS drives"), (SaysEmergencies, "# CiA 402 drives")]
)
def test_the_page_tells_every_fault_of_the_drives(needs, begins):
    text = page("simulating").split(begins)[1]
    for name, fault in FAULTS.items():
        assert f"`{name}`" in text or fault.needs is not needs
