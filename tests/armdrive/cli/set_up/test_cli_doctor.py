"""`armdrive doctor`: asks before it opens, and says what it found."""

import os
import socket
import sys
import threading

import pytest
from amounts import THOROUGH, every_row
from can_setup_bench import arm
from cli_calls import Terminal, write_arm_file, write_bench
from doctor_bench import (
    NUMBER,
    THREE_AXES,
    RewritingDevice,
    ScriptedDevice,
    SimPort,
    TwinBus,
    made,
    plug,
)
from served import Served

from armdrive.arm.device import ControllerMemory
from armdrive.connect import parts
from armdrive.connect.parts import assemble
from armdrive.connect.port import explaining
from armdrive.dialects.bus.tools import Listened
from armdrive.errors import PortUnavailable
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.setup import bus_survey, dialog_runner
from armdrive.setup import prober as carrying
from armdrive.setup import prober as probing
from armdrive.setup.dialog_runner import DialogClock
from armdrive.storage.arm_lock import hold
from armdrive.tasks import DeviceSettings, Difference
from armdrive.trace.recorder import FlightRecorder
from armdrive.transports import opening
from armdrive.transports import ports as system
from armdrive.transports.ports import CanPort, PortInfo
from firmware_protocol import mks
from firmware_protocol.robko01 import Pong
from firmware_protocol.robko01.messages import encode_answer

# Before anything is opened.


def test_without_consent_nothing_is_opened_and_the_doctor_says_why(call, port, lead_to):
    opened = lead_to(made("teachmover"))
    for words in ((), ("--json",)):
        called = call("doctor", str(port), *words, code=3)
        for word in ("can restart the board", "sags", "Add --yes"):
            assert word in called.err
    assert opened == []


@pytest.mark.parametrize(("answer", "code", "times"), [("yes", 0, 1), ("no", 3, 0)])
def test_a_person_is_asked_first(call, port, lead_to, monkeypatch, answer, code, times):
    monkeypatch.setattr(sys, "stdin", Terminal(f"{answer}\n"))
    opened = lead_to(made("teachmover"))
    called = call("doctor", str(port), code=code)
    assert "Support it, or park it first" in called.out
    assert len(opened) == times


@pytest.mark.skipif(os.name != "posix", reason="needs files as devices")
def test_a_port_that_cannot_be_opened_is_named_before_the_question(
    call, port, tmp_path, lead_to, monkeypatch
):
    name = tmp_path / "ttyUSB7"
    there = [PortInfo("/dev/ttyS0"), PortInfo("/dev/ttyS1")]
    monkeypatch.setattr(system, "_found", lambda: there)
    [finding] = call("doctor", str(name), "--json", code=4).json["findings"]
    assert finding["what"] == f"there is no port {name} (present: /dev/ttyS0, /dev/ttyS1)"
    assert finding["fix"] == "check the cable and the name"
    opened = lead_to(made("teachmover"))
    holding = hold(str(port))
    try:
        assert "is held by" in call.refused("doctor", str(port), "--yes", code=4)
    finally:
        holding.release()
    write_arm_file("bench", 'model = "teachmover"\n')
    assert "`armdrive ports`" in call.refused("doctor", "--arm", "bench", "--yes", code=4)
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    assert "clear that variable" in call.refused("doctor", str(port), "--yes", code=4)
    assert opened == []


# Which arm file the port belongs to.


def test_an_adapter_is_looked_at_by_the_number_in_the_arm_file(call, port, lead_to, monkeypatch):
    plug(monkeypatch, {port: NUMBER})
    write_bench("/dev/ttyUSB9", usb_serial=NUMBER)
    monkeypatch.setattr(parts, "connect_real", parts.connect_simulated)
    opened = lead_to(made("teachmover"))
    called = call("doctor", "--arm", "bench", "--yes", code=0)
    assert opened
    assert f"it belongs to the arm file bench (by the USB serial number {NUMBER})" in called.out


@every_row("words", [(), ("--json",)])
def test_an_unplugged_adapter_is_a_problem_with_a_remedy(call, port, words):
    write_bench(port, usb_serial="OTHER")
    said = call("doctor", "--arm", "bench", "--yes", *words, code=4).out
    assert "no port has the USB serial number OTHER (present: " in said
    assert "): plug" not in said  # the remedy stands apart
    assert "plug the adapter in" in said


def test_a_port_alone_leads_to_its_arm_file(call, port, lead_to, monkeypatch):
    plug(monkeypatch, {port: NUMBER})
    write_bench("", usb_serial=NUMBER)
    lead_to(made("teachmover"))
    called = call("doctor", str(port), "--yes", code=0)
    assert "it belongs to the arm file bench" in called.out
    assert "armdrive doctor --arm bench" in called.out
    assert call("doctor", str(port), "--yes", "--json", code=0).json["arm_files"] == ["bench"]


# What is found.


def test_an_arm_is_named_with_what_to_do_next(call, port, lead_to):
    opened = lead_to(made("teachmover"))
    said = call("doctor", str(port), "--yes", code=0).out
    assert "it speaks teachmover" in said
    assert f"armdrive status --port {port} --dialect teachmover" in said
    assert f"armdrive config new --port {port}" in said
    seen = call("doctor", str(port), "--yes", "--json", code=0).json
    assert (seen["port"], seen["dialect"], seen["baud"]) == (str(port), "teachmover", 9600)
    assert {each["grade"] for each in seen["findings"]} == {"ok"}
    assert seen["next"]
    opened.clear()
    call("doctor", str(port), "--yes", "--baud", "9600", code=0)
    assert opened == [9600]  # the given rate alone
    lead_to(ScriptedDevice())
    said = call("doctor", str(port), "--yes", code=6).out
    assert "transmit and receive" in said
    assert "Next:" not in said


def test_a_port_that_fails_in_the_opening_says_why_and_is_free_again(call, port, monkeypatch):
    def fails(name: str, baud: int) -> SimPort:
        raise PortUnavailable(f"{name} is in use by another program: end that program first")

    monkeypatch.setattr(carrying, "_opened", fails)
    for _ in range(2):
        assert "end that program first" in call.refused("doctor", str(port), "--yes", code=4)


# -- settings compared and fixed -----------------------------------------------------------------


@pytest.fixture
def bench(port, lead_to, monkeypatch):
    """An arm file, its arm at the port, and a connection that is made in this process."""
    write_bench(port)
    lead_to(made("teachmover"))
    made_arms = []

    def connect(config):
        assert config.name == "bench"
        made_arms.append(parts.connect_simulated(config))
        return made_arms[-1]

    monkeypatch.setattr(parts, "connect_real", connect)
    return made_arms


def differ(monkeypatch, differences: list[Difference]) -> list[str]:
    """Have the controller's settings differ until they are fixed; return what is written."""

    written: list[str] = []

    def fix(memory, lines=None):
        written.extend(lines)
        for each in list(differences):
            if each.fix in lines:
                differences.remove(each)
        return DeviceSettings(tuple(differences))

    monkeypatch.setattr(ControllerMemory, "fix_settings", fix)
    return written


MUST = Difference("step idle delay $1", "25", "255", "$1=255")
MAY = Difference("max rate $110", "500", "600", "$110=600", must=False)


def test_an_arm_file_has_its_settings_compared_and_its_motors_left_as_they_are(call, bench):
    said = call("doctor", "--arm", "bench", "--yes", code=0).out
    assert "settings are what the arm file expects" in said
    assert "armdrive status --arm bench" in said
    assert bench[0].core.state.name == "DISCONNECTED"


def test_each_difference_is_shown_and_mended_when_that_is_asked_for(call, bench, monkeypatch):
    written = differ(monkeypatch, [MUST, MAY])
    said = call("doctor", "--arm", "bench", "--yes", code=1).out
    assert "problem  step idle delay $1 is 25, expected 255" in said
    assert "$1=255" in said
    assert "note     max rate $110" in said
    assert "armdrive doctor --arm bench --fix" in said
    assert written == []
    said = call("doctor", "--arm", "bench", "--yes", "--fix", code=0).out
    assert written == ["$1=255", "$110=600"]
    assert "2 settings were written" in said


def test_another_dialect_than_the_arm_file_says_is_not_connected_to(call, bench, lead_to):
    lead_to(made("robko01"))
    said = call("doctor", "--arm", "bench", "--yes", code=1).out
    assert "the device speaks robko01, not teachmover" in said
    assert bench == []


def test_a_port_with_a_dialect_is_connected_to_and_a_failure_is_a_problem(
    call, port, lead_to, monkeypatch
):
    lead_to(made("teachmover"))

    def connect(config):
        assert (config.connection.port, config.connection.dialect) == (str(port), "teachmover")
        raise PortUnavailable("it is gone: plug it in")

    monkeypatch.setattr(parts, "connect_real", connect)
    said = call("doctor", str(port), "--dialect", "teachmover", "--yes", code=1).out
    assert "did not connect: it is gone" in said


def test_the_doctor_explains_a_board_with_too_few_axes(call, port, lead_to, monkeypatch):
    text = f'model = "minimover5"\n[connection]\ndialect = "grbl"\nport = "{port}"\n'
    write_arm_file("bench", text)
    lead_to(RewritingDevice(made("grbl"), *THREE_AXES))
    board = SimPort(RewritingDevice(made("grbl"), *THREE_AXES))

    def connect(config):
        recorder = FlightRecorder()
        with explaining(recorder.ring.entries, config.connection):
            return assemble(config, board, SimulatedPace(), simulated=True, tracer=recorder)

    monkeypatch.setattr(parts, "connect_real", connect)
    said = call("doctor", "--arm", "bench", "--yes", code=1).out
    said = " ".join(said.split())
    assert "the board has 3 axes (XYZ), but grbl.axes also puts motors of this arm on A, B" in said
    assert "use a board and a firmware with an axis for each motor" in said
    assert "try once more" not in said
    assert "finds out what is there" not in said.partition("did not connect")[2]


# End to end.


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
@pytest.mark.parametrize("kind", ["pty", "tcp"] if THOROUGH else ["pty"])
def test_a_served_arm_is_found_and_does_not_move(call, tmp_path, monkeypatch, kind):
    monkeypatch.setattr(probing, "LISTEN_S", 0.1)
    where = {"pty": tmp_path / "arm"} if kind == "pty" else {"tcp": "127.0.0.1:0"}
    with Served("robko01", **where) as sim:
        before = sim.watch.motors
        seen = call("doctor", sim.port, "--baud", "115200", "--yes", "--json", code=0).json
        assert seen["dialect"] == "robko01"
        assert sim.watch.motors == before


def test_a_robko_answers_over_udp(call):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        heard = []

        def answer() -> None:
            data, address = peer.recvfrom(100)
            heard.append(data)
            peer.sendto(encode_answer(Pong()), address)

        thread = threading.Thread(target=answer)
        thread.start()
        url = f"udp://127.0.0.1:{peer.getsockname()[1]}"
        said = call("doctor", url, "--yes", code=0).out
        thread.join(5.0)
    assert heard == [b"\xaa\x01\x01\x01\xab\x00"]
    assert "it speaks robko01: Robko 01 SUPER protocol\n" in said
    assert f"armdrive status --port {url} --dialect robko01\n" in said


# `armdrive doctor --can`: on simulated time, but for the listening.


ARM = 'model = "minimover5-mks"\n\n[connection]\ndialect = "mks"\nport = "{port}"\n'
BUS = "can:slcan:/dev/ttyACM0?bitrate=500000"


@pytest.fixture
def drives(monkeypatch):
    """Have every adapter lead to simulated drives that have their ids, on one simulated clock."""
    twin, clock = simulate(arm()), SimulatedClock()

    class Clock(DialogClock):
        def sleep(self, link, until_s):
            self._now_s = clock.now_s
            super().sleep(link, until_s)
            clock.now_s = self._now_s

        def now_s(self):
            return clock.now_s

    def connect(config):
        return parts.connect_simulated(config, twin=twin, pace=clock)

    monkeypatch.setattr(twin.link, "close", lambda: None)
    monkeypatch.setattr(parts, "connect_real", connect)
    monkeypatch.setattr(dialog_runner, "RealClock", Clock)
    monkeypatch.setattr(
        opening, "open_can_link", lambda port: TwinBus(twin.link, right="bitrate=500000" in port)
    )
    return twin


def test_a_bus_is_looked_at_and_an_arm_file_mended(call, drives, monkeypatch):
    there = [CanPort(BUS, ""), CanPort("can:socketcan:can1", "", "bring it up")]
    monkeypatch.setattr(system, "list_can_ports", lambda ports: there)
    seen = call("doctor", "--can", "--json", code=0).json
    assert [each["id"] for each in seen["drives"]] == [1, 2, 3, 4, 5, 6]
    assert seen["bus"]["state"] == "active"
    ids = ("--ids", "1-6")
    write_arm_file("bench", ARM.format(port=BUS))
    drives.board.node(2).set_mode(mks.Mode.PULSE_FOC, drives.board.now_s)
    said = call("doctor", "--arm", "bench", *ids, code=1).out
    assert "drive 3: mode 2 (CR_vFOC)" in said
    assert "`armdrive doctor --arm bench --fix`" in said
    said = call("doctor", "--arm", "bench", *ids, "--fix", "--yes", code=0).out
    assert "1 setting was written" in said
    assert "every drive of the arm file answers" in said


def test_an_empty_bus_is_told_from_a_wrong_rate(call, drives):
    wrong = BUS.replace("500000", "250000")
    said = call("doctor", wrong, "--ids", "1-2", code=6).out
    assert "no node answers to the ids 1, 2, and no node acknowledges a frame" in said
    for motor in range(6):
        drives.board.node(motor).port.plugged = False
    assert "took every frame" in call("doctor", BUS, "--ids", "1-2", code=6).out


def test_no_drive_is_asked_while_another_program_commands_drives(call, drives, monkeypatch):
    with hold(BUS):
        assert "is held by" in call.refused("doctor", BUS, code=4)
    order = mks.encode(2, mks.ReadEncoder())
    monkeypatch.setattr(bus_survey, "listened", lambda *_: Listened((order,), (order,)))
    monkeypatch.setattr(opening, "open_can_link", lambda _port: pytest.fail("the bus was opened"))
    assert "so no drive was asked: end that program" in call("doctor", BUS, code=1).out


def test_without_a_bus_the_adapters_are_listed(call, monkeypatch):
    monkeypatch.setattr("serial.tools.list_ports.comports", list)
    listed = "armdrive.transports.ports.list_can_ports"
    monkeypatch.setattr(listed, lambda ports: [])
    assert "no adapter was found" in call.refused("doctor", "--can", code=4)
    two = [CanPort("can:socketcan:can0", ""), CanPort("can:socketcan:can1", "")]
    monkeypatch.setattr(listed, lambda ports: two)
    assert "can:socketcan:can0, can:socketcan:can1" in call.refused("doctor", "--can", code=4)
    assert "which bus?" in call.refused("doctor", "--can", "--dialect", "mks", code=4)
