"""What is behind a port is found out, in words, as the doctor does; listing opens nothing."""

import pytest
from can_setup_bench import arm
from canopen_nodes import Device, NodesBus
from doctor_bench import SimPort, made

from armdrive.dialog.conversation import WrongAnswer
from armdrive.errors import PortUnavailable
from armdrive.registry import simulate
from armdrive.registry.arm_files import arm_path
from armdrive.setup import dialog_runner
from armdrive.setup import prober as carrying
from armdrive.setup.bus_survey import probe
from armdrive.setup.dialog_runner import DialogClock
from armdrive.setup.filing import checked, file_of, write
from armdrive.setup.interview import Describing
from armdrive.setup.ports import closed_ports, look_at
from armdrive.transports import can_link
from armdrive.transports.can_health import BusHealth
from firmware_protocol.canopen import DEVICE_TYPE


@pytest.mark.parametrize("dialect", ["teachmover", "robko01", "grbl", "armdroid"])
def test_a_port_is_recognised_and_its_arm_is_described_by_what_was_found(dialect, monkeypatch):
    port = SimPort(made(dialect))
    monkeypatch.setattr(carrying, "_opened", lambda name, baud: port)
    monkeypatch.setattr(dialog_runner, "RealClock", DialogClock)
    found = probe("/dev/arm")
    assert found.dialect == dialect
    assert f"it speaks {dialect}" in found.lines[0]
    assert port.closed
    describing = Describing(found.answers)
    describing.typed = "lab"
    describing.enter()
    assert describing.question.key == "template"
    while describing.question is not None:
        describing.enter()
    files = describing.files()
    config = checked(files, "lab")
    assert config.connection.port == "/dev/arm"
    assert config.connection.dialect == dialect
    assert config.connection.baud == found.more["baud"]


def test_a_forced_simulation_opens_no_port(monkeypatch):
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    for port in ("/dev/arm", "can:socketcan:can0"):
        with pytest.raises(PortUnavailable, match="ARMDRIVE_FORCE_SIM"):
            probe(port)


def test_ports_and_interfaces_are_listed_with_what_is_known_of_them(monkeypatch):
    from armdrive.transports import ports
    from armdrive.transports import ports as can_ports
    from armdrive.transports.ports import CanPort

    monkeypatch.setattr(ports, "list_ports", lambda: ())
    buses = [CanPort("can:socketcan:can0", "PEAK adapter", "bring it up: ip link set can0 up")]
    monkeypatch.setattr(can_ports, "list_can_ports", lambda _ports: buses)
    (only,) = closed_ports()
    assert only.port == "can:socketcan:can0"
    assert not only.openable
    assert only.lines == ("PEAK adapter", "note: bring it up: ip link set can0 up")


def test_a_port_that_is_not_there_is_said_before_anything_is_opened():
    known = look_at("/dev/nothing-here")
    assert not known.openable
    assert "/dev/nothing-here" in known.lines[0]


class TwinBus:
    """The wire of simulated drives, which stays open when an adapter on it is closed."""

    health = BusHealth()

    def __init__(self, drives):
        link = simulate(drives).link
        self.write, self.read, self.next_s = link.write, link.read, link.next_s

    def close(self):
        """Stay open."""


def test_mks_drives_are_found_and_offered_their_template(monkeypatch):
    bus = TwinBus(arm())
    monkeypatch.setattr(can_link, "open_can_link", lambda port: bus)
    clock = DialogClock()
    monkeypatch.setattr(dialog_runner, "RealClock", lambda: clock)
    found = probe("can:slcan:/dev/ttyACM0?bitrate=500000")
    assert found.dialect == "mks"
    assert "armdrive can setup" in found.lines[-1]
    describing = Describing(found.answers)
    describing.typed = "lab"
    describing.enter()
    assert describing.line == "minimover5-mks"


def test_canopen_drives_are_found_and_offered_their_template(monkeypatch):
    bus = NodesBus(*map(Device, range(1, 7)))
    monkeypatch.setattr(can_link, "open_can_link", lambda port: bus)
    monkeypatch.setattr(dialog_runner, "RealClock", DialogClock)
    found = probe("can:slcan:/dev/ttyACM0?bitrate=500000")
    assert found.dialect == "cia402"
    assert any("these answer: 1, 2, 3, 4, 5, 6 (CANopen)" in line for line in found.lines)
    assert not any("can setup" in line for line in found.lines)
    describing = Describing(found.answers)
    describing.typed = "lab"
    describing.enter()
    assert describing.line == "minimover5-cia402"
    module = Device(1).has({DEVICE_TYPE: 0x191})  # an I/O module drives no arm
    for bus.devices in ((module,), ()):
        assert probe("can:slcan:/dev/ttyACM0?bitrate=500000").dialect == ""


def test_going_back_goes_over_what_was_found():
    describing = Describing({"connection.port": "/dev/arm", "dialect": "teachmover"})
    describing.typed = "lab"
    describing.enter()
    describing.enter()
    assert describing.question.key == "title"
    assert describing.back()
    assert describing.question.key == "template"
    assert describing.back()
    assert describing.question.key == "name"
    assert not describing.back()
    assert describing.question.key == "name"


def test_a_found_answer_that_does_not_fit_is_asked_for_after_all():
    describing = Describing({"connection.port": "nonsense"})
    describing.typed = "lab"
    while describing.question.key != "connection.port":
        describing.enter()
    describing.typed = "nonsense"
    with pytest.raises(WrongAnswer):
        describing.enter()


def test_the_file_of_an_arm_is_known_until_somebody_changes_it(tmp_path, monkeypatch):
    from armdrive.registry.arm_files import load_arm

    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    describing = Describing({})
    describing.typed = "lab"
    while describing.question is not None:
        if describing.question.key == "title":
            describing.typed = "My_bench"  # on a desk the space bar stops
        describing.enter()
    path = arm_path("lab")
    path.parent.mkdir(parents=True)
    write(describing.files(), path)
    config = load_arm(path)
    assert (config.name, config.title) == ("lab", "My bench")
    assert file_of(config) == path
    path.write_text(path.read_text(encoding="utf-8") + "\n[limits_deg]\nbase = [-1, 1]\n")
    assert file_of(config) is None
