"""`armdrive doctor` with an arm file or a dialect: settings compared and mended; end to end."""

from __future__ import annotations

import socket
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from cli_calls import write_arm_file
from doctor_bench import THREE_AXES, Rewritten, SimPort, made

from armdrive.connect import parts as connecting
from armdrive.connect.parts import assemble
from armdrive.connect.port import explaining
from armdrive.errors import PortUnavailable
from armdrive.runtime.clock import SimulatedPace
from armdrive.setup import prober as probing
from armdrive.tasks import DeviceSettings, Difference
from armdrive.trace.recorder import FlightRecorder
from firmware_protocol.robko01 import Device

if sys.platform != "win32":
    sys.path.insert(0, str(Path(__file__).parents[4] / "benchmarks"))
    from sim_process import SimProcess


@pytest.fixture
def bench(port, lead_to, monkeypatch):
    """An arm file, its arm at the port, and a connection that is made in this process."""
    write_arm_file("bench", f'model = "teachmover"\n[connection]\nport = "{port}"\n')
    lead_to(made("teachmover"))
    made_arms = []

    def connect(config):
        assert config.name == "bench"
        made_arms.append(connecting.connect_simulated(config))
        return made_arms[-1]

    monkeypatch.setattr(connecting, "connect_real", connect)
    return made_arms


def differ(monkeypatch, differences: list[Difference]) -> list[str]:
    """Have the controller's settings differ until they are mended; return what is written."""
    from armdrive.arm import Arm

    written: list[str] = []

    def mend(arm, lines=None):
        written.extend(lines)
        for each in list(differences):
            if each.mend in lines:
                differences.remove(each)
        return DeviceSettings(tuple(differences))

    monkeypatch.setattr(Arm, "mend_settings", mend)
    return written


MUST = Difference("step idle delay $1", "25", "255", "$1=255")
MAY = Difference("max rate $110", "500", "600", "$110=600", must=False)


def test_an_arm_file_has_its_settings_compared_and_its_motors_left_as_they_are(call, bench):
    said = call("doctor", "--arm", "bench", "--yes", code=0).out
    assert "settings are what the arm file expects" in said
    assert "armdrive status --arm bench" in said
    assert "Or as an arm file" not in said
    assert bench[0].core.state.name == "DISCONNECTED"


def test_each_difference_is_shown_with_the_line_that_corrects_it(call, bench, monkeypatch):
    written = differ(monkeypatch, [MUST, MAY])
    said = call("doctor", "--arm", "bench", "--yes", code=1).out
    assert "problem  step idle delay $1 is 25, expected 255" in said
    assert "$1=255" in said
    assert "note     max rate $110" in said
    assert written == []


def test_they_are_mended_when_that_is_asked_for(call, bench, monkeypatch):
    written = differ(monkeypatch, [MUST, MAY])
    said = call("doctor", "--arm", "bench", "--yes", "--mend", code=0).out
    assert written == ["$1=255", "$110=600"]
    assert "2 settings were written" in said


def test_another_dialect_than_the_arm_file_says_is_not_connected_to(call, bench, lead_to):
    lead_to(made("robko01"))
    said = call("doctor", "--arm", "bench", "--yes", code=1).out
    assert "the device speaks robko01, not teachmover" in said
    assert bench == []


def test_a_port_with_a_dialect_is_compared_too(call, port, lead_to, monkeypatch):
    lead_to(made("teachmover"))
    connected = []

    def connect(config):
        connected.append(config.connection)
        return connecting.connect_simulated(replace(config, name="sim"))

    monkeypatch.setattr(connecting, "connect_real", connect)
    call("doctor", str(port), "--dialect", "teachmover", "--yes", code=0)
    assert [(wire.port, wire.dialect) for wire in connected] == [(str(port), "teachmover")]


def test_a_connection_that_fails_is_a_problem_and_no_crash(call, port, lead_to, monkeypatch):
    lead_to(made("teachmover"))

    def connect(config):
        raise PortUnavailable("it is gone: plug it in")

    monkeypatch.setattr(connecting, "connect_real", connect)
    said = call("doctor", str(port), "--dialect", "teachmover", "--yes", code=1).out
    assert "did not connect: it is gone" in said


def test_the_doctor_on_a_board_with_too_few_axes_says_what_is_wrong_and_what_helps(
    call, port, lead_to, monkeypatch
):
    text = f'model = "minimover5"\n[connection]\ndialect = "grbl"\nport = "{port}"\n'
    write_arm_file("bench", text)
    lead_to(Rewritten(made("grbl"), *THREE_AXES))
    board = SimPort(Rewritten(made("grbl"), *THREE_AXES))

    def connect(config):
        recorder = FlightRecorder()
        with explaining(recorder.ring.entries, config.connection):
            return assemble(config, board, SimulatedPace(), simulated=True, tracer=recorder)

    monkeypatch.setattr(connecting, "connect_real", connect)
    said = call("doctor", "--arm", "bench", "--yes", code=1).out
    said = " ".join(said.split())
    assert "the board has 3 axes (XYZ), but grbl.axes also puts motors of this arm on A, B" in said
    assert "use a board and a firmware with an axis for each motor" in said
    assert "try once more" not in said
    assert "finds out what is there" not in said.partition("did not connect")[2]


# End to end.


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_a_simulated_arm_in_another_process_is_found_and_does_not_move(
    call, tmp_path, monkeypatch, kind
):
    monkeypatch.setattr(probing, "LISTEN_S", 0.1)
    with SimProcess(tmp_path / "arm" if kind == "pty" else None, "robko01") as sim:
        before = sim.state()["motors"]
        seen = call("doctor", sim.port, "--baud", "115200", "--yes", "--json", code=0).json
        assert seen["dialect"] == "robko01"
        assert sim.state()["motors"] == before


def test_a_robko_answers_over_udp(call):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        heard = []

        def answer() -> None:
            from firmware_protocol.robko01 import Pong

            data, address = peer.recvfrom(100)
            heard.append(data)
            device = Device()
            device.receive_data(data)
            assert device.next_event() is not None
            peer.sendto(device.send(Pong()), address)

        thread = threading.Thread(target=answer)
        thread.start()
        url = f"udp://127.0.0.1:{peer.getsockname()[1]}"
        said = call("doctor", url, "--yes", code=0).out
        thread.join(5.0)
    assert heard == [b"\xaa\x01\x01\x01\xab\x00"]
    assert "it speaks robko01: Robko 01 SUPER protocol\n" in said
    assert f"armdrive status --port {url} --dialect robko01\n" in said
