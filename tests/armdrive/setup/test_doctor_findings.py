"""Who is recognised by what was heard, and which findings come of it."""

import pytest
from amounts import every_row
from can_setup_bench import arm
from canopen_nodes import Device, NodesBus
from doctor_bench import (
    BANNER,
    PROBES,
    SPOKEN,
    WHO,
    EchoDevice,
    ScriptedDevice,
    SimPort,
    TwinBus,
    made,
)
from hypothesis import given
from hypothesis import strategies as st
from pages import page

from armdrive.config.sections import Connection
from armdrive.connect.control_socket import serve_stop
from armdrive.dialects.recognition import Identity, excerpt
from armdrive.dialog import Grade, WrongAnswer, any_problem
from armdrive.errors import PortUnavailable
from armdrive.registry import DIALECTS, simulate
from armdrive.registry.arm_files import arm_path, load_arm
from armdrive.setup import dialog_runner
from armdrive.setup import prober as carrying
from armdrive.setup import survey as after
from armdrive.setup.bus_survey import probe
from armdrive.setup.dialog_runner import DialogClock
from armdrive.setup.filing import checked, file_of, write
from armdrive.setup.interview import Describing
from armdrive.setup.ports import closed_ports, latency, look_at
from armdrive.setup.prober import Examination, ProbeReply
from armdrive.setup.survey import of_settings
from armdrive.storage.arm_lock import hold
from armdrive.tasks import DeviceSettings, Difference
from armdrive.transports import opening, ports
from armdrive.transports.ports import CanPort
from firmware_protocol.canopen import DEVICE_TYPE, INCREMENTS_A_SECOND, SPEED_UNIT


@every_row(
    "heard, dialect, firmware, greeted",
    [
        (b"Welcome, Armdroid!\r\n", "armdroid", "Armdroid serial driver", True),
        (b"version = 1.3\r\n", "armdroid", "Armdroid serial driver 1.3", False),
        (b"xx\r\noffsets = 1,2,3,4,5,-6\r\n", "armdroid", "Armdroid serial driver", False),
        (BANNER, "grbl", "Grbl 1.1h", True),
        (b"\xfe\x00lo" + BANNER + b"<Idle|MPos:0.000,0.000,0.000>", "grbl", "Grbl 1.1h", True),
        (b"\r\nGrbl 1.1h ['$' fo", "grbl", "Grbl 1.1h", True),
        (b"GrblHAL 1.1f ['$' or '$HELP' for help]\r\n", "grbl", "GrblHAL 1.1f", True),
        (
            b"Grbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]\r\n",
            "grbl",
            "FluidNC v3.7.8 (wifi)",
            True,
        ),
        (
            b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n",
            "grbl",
            "a firmware of the GRBL family",
            False,
        ),
        (b"error:9\r\n", "grbl", "a firmware of the GRBL family", False),
        (BANNER + b"[VER:1.1h.20190830:]\r\nok\r\n", "grbl", "Grbl 1.1h (1.1h.20190830)", True),
        (b"?\xaa\x02\x02\x01\x01\xa9\x03?", "robko01", "Robko 01 SUPER protocol", False),
        (b"0\r1\r1,-2,3,4,5,6,0\r", "teachmover", "TeachMover", False),
        (b"\r\n1, -2, 3, 4, 5, 6, 0\r\n", "", "Robko 01 retrofit, in its text mode", False),
        (b"start\necho:Marlin 2.1\n", "", "Marlin, the firmware of a 3D printer", False),
        (b"rst:0x1 (POWERON_RESET)\r\n", "", "an ESP32 whose firmware has sent nothing yet", False),
    ],
)
def test_a_device_is_recognised_by_what_it_sends(heard, dialect, firmware, greeted):
    assert WHO.recognise(heard) == Identity(dialect, firmware, greeted)


@every_row(
    "heard",
    [b"", b"ok\r\n", b"0\r", b"1\r", b"1\r1,2,3", b"Gr", b"offsets = 1,2", b"\xaa\x02\x02\x01\x01"],
)
def test_too_few_bytes_recognise_no_device(heard):
    assert WHO.recognise(heard) is None


@given(st.binary(max_size=200))
def test_recognition_fails_on_no_bytes(heard):
    WHO.recognise(heard)
    excerpt(heard)


@every_row("dialect", SPOKEN)
@every_row("own_baud", [True, False])
def test_every_simulated_arm_is_found_with_what_to_do_next(dialect, own_baud):
    device = made(dialect)
    found = SimPort(device).examine(device.board.baud if own_baud else None)
    findings = after.of_examination(found)
    assert not any_problem(findings)
    assert f"it speaks {dialect}" in findings[0].what
    next_steps = after.next_steps("/dev/ttyUSB0", found)
    assert next_steps[-2] == f"armdrive status --port /dev/ttyUSB0 --dialect {dialect}"
    assert next_steps[-1] == "armdrive config new --port /dev/ttyUSB0"


def test_the_rate_of_a_board_is_its_own_where_it_has_one():
    board = made("grbl")
    for baud, found in ((9600, 9600), (None, 115_200)):  # the second over native USB
        board.board.baud = baud
        assert SimPort(board).examine().baud == found
    silent = SimPort(ScriptedDevice()).examine()
    assert [each.baud for each in silent.replies if not each.probe] == [115_200, 9600] * 2


def test_a_port_is_left_so_that_the_next_opening_restarts_no_board(monkeypatch):
    asked = []
    monkeypatch.setattr(carrying, "SerialLink", lambda *_, **settings: asked.append(settings))
    carrying._opened("/dev/arm", 9600)
    assert asked == [{"raise_dtr": True, "keep_dtr_on_close": True}]


RESTARTED = SimPort(ScriptedDevice((1.0, BANNER), baud=115200)).examine(115200)
DTR = {"raise_dtr": True, "keep_dtr_on_close": True}


@every_row(
    "found, connection, grade, said",
    [
        (RESTARTED, None, Grade.NOTE, "keep_dtr_on_close = true"),
        (RESTARTED, Connection("grbl", **DTR), Grade.NOTE, "the first"),
        (Examination(Identity("grbl", "x", greeted=True)), None, Grade.NOTE, "arm sags; "),
        (
            Examination(Identity("grbl", "x"), 9600, (ProbeReply("?", 9600, b"$I", b"$Iok"),)),
            None,
            Grade.PROBLEM,
            "echoes everything that is sent; switch the echo off",
        ),
        # observed: an Armdroid greets whoever opens its port; its motors keep holding
        (
            SimPort(ScriptedDevice((0.5, b"Welcome, Armdroid!\r\n"))).examine(9600),
            None,
            Grade.OK,
            "it speaks armdroid: Armdroid serial driver at 9600 baud",
        ),
        (
            SimPort(ScriptedDevice(answers=b"version = 1.3\r\n")).examine(9600),
            Connection("teachmover"),
            Grade.PROBLEM,
            'the device speaks armdroid, not teachmover; write dialect = "armdroid"',
        ),
    ],
)
def test_what_an_arm_did_is_the_last_finding_with_its_remedy(found, connection, grade, said):
    last = after.of_examination(found, connection=connection)[-1]
    assert last.grade is grade
    assert said in f"{last.what}; {last.fix}"


@every_row("dialect", DIALECTS)
def test_every_dialect_is_recommended_with_its_rate_if_that_is_unusual(dialect):
    found = Examination(Identity(dialect, dialect), 19200)
    assert after.next_steps("COM 3", found)[0].endswith(f"--dialect {dialect} --baud 19200")


MUST = Difference("step idle delay $1", "25", "255", "$1=255")
MAY = Difference("max rate $110", "500", "600", "$110=600", must=False)


@every_row(
    "settings, grades",
    [
        (DeviceSettings((MUST, MAY)), [Grade.PROBLEM, Grade.NOTE]),
        (DeviceSettings((MAY,), "Grbl 1.1h"), [Grade.OK, Grade.NOTE]),
        (DeviceSettings((), "Grbl 1.1h"), [Grade.OK, Grade.OK]),
    ],
)
def test_settings_that_differ_are_findings_with_the_line_that_mends_them(settings, grades):
    listed = of_settings(settings)
    assert [each.grade for each in listed] == grades
    assert [each.fix for each in listed if each.fix] == [each.fix for each in settings.differences]


NO_ARM = {
    # what is behind the port, the only rate that was tried if there was one, and what is said
    "silence at every rate": (ScriptedDevice(), None, "no device answers at 9600 and 115200 baud"),
    "silence at one rate": (ScriptedDevice(), 2400, "no device answers at 2400 baud; "),
    "an echo": (EchoDevice(), 9600, "comes straight back"),
    "half a line": (ScriptedDevice((1.0, b"Gr")), 9600, "'Gr'"),
    "a printer": (ScriptedDevice(answers=b"echo:Marlin 2.1\n"), 9600, "3D printer"),
    "text mode": (ScriptedDevice(answers=b"\r\n1, 2, 3, 4, 5, 6, 0\r\n"), 9600, "SUPER"),
    "unreadable bytes": (ScriptedDevice((1.0, bytes(range(0x80, 0xA0)))), 9600, "(--baud N)"),
    "an answer to STATUS alone": (
        ScriptedDevice(answers=b"0\r"), 9600, "no answer of an arm that armdrive knows"),
}  # fmt: skip


@every_row("what", NO_ARM)
def test_a_device_that_is_no_arm_is_one_problem_with_a_remedy(what):
    device, baud, said = NO_ARM[what]
    (found,) = after.of_examination(SimPort(device).examine(baud))
    assert found.grade is Grade.PROBLEM
    assert found.fix
    assert said in f"{found.what}; {found.fix}"


def test_an_adapter_that_holds_bytes_back_is_found(tmp_path):
    timer = tmp_path / "ttyUSB0" / "latency_timer"
    timer.parent.mkdir()
    timer.write_text("16\n")
    (found,) = latency("/dev/ttyUSB0", tmp_path)
    assert (found.grade, found.fix) == (Grade.NOTE, f"echo 1 | sudo tee {timer}")
    timer.write_text("1\n")
    assert latency("/dev/ttyUSB0", tmp_path)[0].grade is Grade.OK
    timer.write_text("?")
    assert latency("/dev/ttyUSB0", tmp_path) == []
    assert latency("/dev/ttyACM0", tmp_path) == []


def test_the_page_shows_every_probe_as_it_is_said():
    text = page("protocols")
    for each in PROBES:
        said = each.data.decode("latin-1").encode("unicode_escape").decode("ascii")
        assert f"`{said}` |" in text, each
        assert f"| {each.baud} |" in text


# What is behind a port is found out, in words, as the doctor does; listing opens nothing.


def test_a_found_answer_that_does_not_fit_is_asked_for_and_one_that_fits_is_passed_over():
    describing = named_lab({"connection.port": "/dev/arm", "dialect": "teachmover"})
    describing.enter()
    assert describing.question.key == "title"
    assert describing.back()
    assert describing.question.key == "template"
    assert describing.back()
    assert not describing.back()
    assert describing.question.key == "name"
    describing = named_lab({"connection.port": "nonsense"})
    while describing.question.key != "connection.port":
        describing.enter()
    describing.typed = "nonsense"
    with pytest.raises(WrongAnswer):
        describing.enter()


def named_lab(found):
    """Describe the arm of which this was found, beginning with its name."""
    describing = Describing(found)
    describing.typed = "lab"
    describing.enter()
    return describing


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
def test_a_port_is_recognised_and_its_arm_is_described_by_what_was_found(dialect, monkeypatch):
    port = SimPort(made(dialect))
    monkeypatch.setattr(carrying, "_opened", lambda name, baud: port)
    monkeypatch.setattr(dialog_runner, "RealClock", DialogClock)
    found = probe("/dev/arm")
    assert found.dialect == dialect
    assert f"it speaks {dialect}" in found.lines[0]
    assert port.closed
    describing = named_lab(found.answers)
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
    monkeypatch.setattr(ports, "list_ports", lambda: ())
    buses = [CanPort("can:socketcan:can0", "PEAK adapter", "bring it up: ip link set can0 up")]
    monkeypatch.setattr(ports, "list_can_ports", lambda _ports: buses)
    (only,) = closed_ports()
    assert only.port == "can:socketcan:can0"
    assert not only.openable
    assert only.lines == ("PEAK adapter", "note: bring it up: ip link set can0 up")
    known = look_at("/dev/nothing-here")
    assert not known.openable
    assert "/dev/nothing-here" in known.lines[0]


@pytest.mark.parametrize("kind", ["network", "terminal"])
def test_a_port_that_an_armdrive_program_holds_is_in_use_whatever_the_system_knows(tmp_path, kind):
    (tmp_path / "tty").touch()
    port = "socket://127.0.0.1:4001" if kind == "network" else str(tmp_path / "tty")
    with hold(port) as lock:
        serve_stop(lock, "drives")
        known = look_at(port)
    assert (known.openable, known.driven) == (False, port)
    assert "an armdrive program drives an arm on it" in known.lines[-1]
    assert look_at(port).openable


def test_mks_drives_are_found_and_offered_their_template(monkeypatch):
    bus = TwinBus(simulate(arm()).link)
    monkeypatch.setattr(opening, "open_can_link", lambda port: bus)
    clock = DialogClock()
    monkeypatch.setattr(dialog_runner, "RealClock", lambda: clock)
    found = probe("can:slcan:/dev/ttyACM0?bitrate=500000")
    assert found.dialect == "mks"
    assert "armdrive can setup" in found.lines[-1]
    describing = named_lab(found.answers)
    assert describing.line == "minimover5-mks"


def test_canopen_drives_are_found_and_offered_their_template(monkeypatch):
    unit = {SPEED_UNIT: INCREMENTS_A_SECOND}
    bus = NodesBus(*(Device(number).has(unit) for number in range(1, 7)))
    monkeypatch.setattr(opening, "open_can_link", lambda port: bus)
    monkeypatch.setattr(dialog_runner, "RealClock", DialogClock)
    found = probe("can:slcan:/dev/ttyACM0?bitrate=500000")
    assert found.dialect == "cia402"
    assert any("these answer: 1, 2, 3, 4, 5, 6 (CANopen)" in line for line in found.lines)
    assert not any("can setup" in line for line in found.lines)
    describing = named_lab(found.answers)
    assert describing.line == "minimover5-cia402"
    module = Device(1).has({DEVICE_TYPE: 0x191})  # an I/O module drives no arm
    for bus.devices in ((module,), ()):
        assert probe("can:slcan:/dev/ttyACM0?bitrate=500000").dialect == ""


def test_the_file_of_an_arm_is_known_until_somebody_changes_it(tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    describing = named_lab({})
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
