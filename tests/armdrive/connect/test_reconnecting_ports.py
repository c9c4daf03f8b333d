"""Ports that come and go in real time: a pulled cable is seen at once, an adapter found again."""

from __future__ import annotations

import sys
import threading
from dataclasses import replace
from types import SimpleNamespace

import pytest
from served import Served
from waiting import LONG_S, until

from armdrive import Arm, LinkLost
from armdrive.config.sections import Connection
from armdrive.connect import port as mending
from armdrive.connect.port import NewLink, PortOpening, Reconnector
from armdrive.connect.target import find
from armdrive.errors import NoSuchPort, PortInUse, PortUnavailable
from armdrive.status import State, Trust
from armdrive.transports import ports

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
NUMBER = "A50285BI"


@pytest.fixture
def plugged(monkeypatch):
    """USB adapters that this computer is made to believe in: name of the port to number."""
    adapters: dict[str, str] = {}

    def found():
        return [SimpleNamespace(device=name, serial_number=adapters[name]) for name in adapters]

    monkeypatch.setattr(ports, "_found", found)
    return adapters


class TestFinding:
    def test_an_adapter_is_found_under_any_name(self, plugged):
        plugged["/dev/ttyUSB7"] = NUMBER
        assert ports.device_of(NUMBER) == "/dev/ttyUSB7"
        assert ports.device_of(NUMBER, "/dev/ttyUSB0") == "/dev/ttyUSB7"
        assert ports.serial_number_of("/dev/ttyUSB7") == NUMBER
        assert ports.serial_number_of("/dev/ttyUSB0") == ""

    def test_an_adapter_that_is_not_there_is_named_with_those_that_are(self, plugged):
        plugged["/dev/ttyUSB7"] = "OTHER"
        plugged["/dev/ttyS0"] = None
        with pytest.raises(NoSuchPort, match=rf"{NUMBER} \(present: OTHER \(/dev/ttyUSB7\)\)"):
            ports.device_of(NUMBER)
        plugged.clear()
        with pytest.raises(NoSuchPort, match="none with a number"):
            ports.device_of(NUMBER)

    def test_adapters_of_one_number_are_told_apart_by_name_or_not_at_all(self, plugged):
        plugged["/dev/ttyUSB1"] = plugged["/dev/ttyUSB2"] = NUMBER
        assert ports.device_of(NUMBER, "/dev/ttyUSB2") == "/dev/ttyUSB2"
        with pytest.raises(NoSuchPort, match="/dev/ttyUSB1 and /dev/ttyUSB2"):
            ports.device_of(NUMBER, "/dev/ttyUSB0")

    def test_a_name_that_udev_has_made_is_kept_while_it_leads_there(self, plugged, tmp_path):
        device, link = tmp_path / "ttyUSB0", tmp_path / "by-id"
        device.touch()
        link.symlink_to(device)
        plugged[str(device)] = NUMBER
        assert ports.serial_number_of(str(link)) == NUMBER
        assert ports.device_of(NUMBER, str(link)) == str(link)

    def test_an_arm_file_may_give_the_number_alone(self, plugged):
        config = find("/dev/ttyUSB0", dialect_name="teachmover").config
        wiring = PortOpening(
            replace(config, connection=Connection("teachmover", usb_serial=NUMBER))
        )
        with pytest.raises(NoSuchPort):
            wiring.open()
        plugged["/dev/no-such-port"] = NUMBER
        assert wiring.find() == "/dev/no-such-port"
        with pytest.raises(PortUnavailable, match="/dev/no-such-port"):
            wiring.open()
        with pytest.raises(PortUnavailable, match="usb_serial"):
            PortOpening(replace(config, connection=Connection("teachmover")))


def moving(arm, there):
    """Begin a motion and wait until the arm itself moves."""
    arm.declare_posture(arm.model.arm.ik(arm.model.reference.pose))
    handle = arm.move_j(shoulder_deg=70, wait=False)
    start = there.device.world.motors
    until(lambda: there.device.world.motors != start)
    return handle


@needs_pty
class TestPty:
    def test_an_adapter_comes_back_under_another_name(self, plugged, tmp_path):
        first, second = tmp_path / "first", tmp_path / "second"
        with Served("teachmover", pty=first) as arm_there:
            plugged[str(first)] = NUMBER
            arm = Arm.connect(str(first), dialect="teachmover", reconnect=True)
            handle = moving(arm, arm_there)
            arm_there.tell("unplug")
            plugged.clear()
            until(lambda: arm.status.state is State.DISCONNECTED)
            with pytest.raises(LinkLost):
                handle.wait()
            # another adapter takes the old name: it is not ours
            with Served("armdroid", pty=first):
                plugged[str(first)] = "OTHER"
                until(lambda: "OTHER" in arm.status.notice)
                assert arm.status.state is State.DISCONNECTED
                plugged[str(second)] = NUMBER
                arm_there.tell(f"replug as {second}")
                until(lambda: arm.status.state is State.ERROR_STOP)
            assert str(second) in arm.status.link
            assert arm.status.trust is Trust.SUSPECT
            arm.close()

    def test_a_port_without_a_number_comes_back_under_its_own_name(self, tmp_path):
        path = tmp_path / "arm"
        with Served("teachmover", pty=path) as there:
            with Arm.connect(str(path), dialect="teachmover", reconnect=True) as arm:
                thread = arm.pace._thread
                there.tell("unplug")
                until(lambda: arm.status.state is State.DISCONNECTED)
                there.tell("replug")
                until(lambda: arm.status.state is State.ERROR_STOP)
                arm.reset()
                assert arm.status.state is State.STANDBY
                assert arm.read_inputs() is not None
            assert not thread.is_alive()

    def test_an_arm_that_is_looked_for_can_be_closed(self, tmp_path):
        path = tmp_path / "arm"
        with Served("teachmover", pty=path) as there:
            arm = Arm.connect(str(path), dialect="teachmover", reconnect=True)
            thread = arm.pace._thread
            there.tell("unplug")
            until(lambda: arm.reconnector.tries > 0)
            arm.close()
            assert not thread.is_alive()
            there.tell("replug")
            Arm.connect(str(path), dialect="teachmover").close()  # the port was given back


TRANSPORTS = [
    pytest.param("pty", marks=needs_pty),
    "tcp",
]


@pytest.mark.parametrize("motion", [False, True], ids=["standing", "moving"])
@pytest.mark.parametrize("transport", TRANSPORTS)
def test_a_lost_wire_is_seen(transport, motion, tmp_path):
    where = {"pty": tmp_path / "arm"} if transport == "pty" else {"tcp": "0"}
    with Served("teachmover", **where) as there:
        arm = Arm.connect(there.port, dialect="teachmover")
        if motion:
            moving(arm, there)
        there.tell("unplug")
        until(lambda: arm.status.state is State.DISCONNECTED)
        arm.close()


@needs_pty
def test_a_lost_wire_is_seen_in_error_stop_too(tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as there:
        arm = Arm.connect(there.port, dialect="teachmover")
        arm.estop()
        there.tell("unplug")
        until(lambda: arm.status.state is State.DISCONNECTED)
        arm.close()


def test_a_network_host_that_closed_its_port_is_seen_at_the_next_look():
    with Served("robko01", udp="0") as there:
        arm = Arm.connect(there.port, dialect="robko01")
        arm.enable()
        assert arm.config.motion.idle_poll_s < 1.0
        there.tell("unplug")
        until(lambda: arm.status.state is State.DISCONNECTED)
        arm.close()


# -- the old wire lets its port go first ----------------------------------------------------------


class OneHolder:
    """A port that one wire at a time can have; a wire is slow to let it go."""

    description = "can:slcan:/dev/ttyACM0"

    def __init__(self) -> None:
        self.asked_for, self.may_close, self.tried = (threading.Event() for _ in range(3))
        self.held = True

    def close(self) -> None:
        self.may_close.wait(LONG_S)
        self.held = False

    def open_again(self):
        if self.held:
            raise PortInUse("in use by another program or by this one")
        raise LinkLost("free, but nobody is there")

    def woken(self) -> None:
        self.tried.set()


@pytest.fixture
def port():
    held = OneHolder()
    yield held
    held.may_close.set()


def looking(port):
    """Return who looks for a wire that was lost a moment ago, and has begun to."""
    engine = SimpleNamespace(link=port)
    core = SimpleNamespace(notify=lambda *_words: None)
    wire = SimpleNamespace(engine=engine, core=core, now_s=0.0)
    reconnector = Reconnector(wire, NewLink(port.open_again, in_thread=True))
    reconnector.lost(0.0)
    engine.link = SimpleNamespace(wake=port.woken)
    reconnector.ask(0.0)
    reconnector(0.0)
    return reconnector


def test_the_old_wire_is_waited_for(port):
    reconnector = looking(port)
    assert not port.tried.wait(0.05)
    port.may_close.set()
    assert port.tried.wait(LONG_S)
    reconnector(0.0)
    assert reconnector.tries == 1
    assert "nobody is there" in str(reconnector.trouble)


def test_an_old_wire_that_never_lets_go_is_waited_for_no_longer_than_that(port, monkeypatch):
    monkeypatch.setattr(mending, "LET_GO_S", 0.01)
    reconnector = looking(port)
    assert port.tried.wait(LONG_S)
    reconnector(0.0)
    assert isinstance(reconnector.trouble, PortInUse)
